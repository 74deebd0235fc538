//! Drawing as inline SVG. Style classes define the colours, which follow light mode, dark mode and print.

use super::names::{CodeStyle, Marker};
use std::fmt::Write as _;

/// Drawing under construction, in units of CSS pixels at its natural size.
pub struct Drawing {
    body: String,
    width: f64,
    height: f64,
}

/// Anchor point of a text.
#[derive(Clone, Copy)]
pub enum Anchor {
    /// Start of the text.
    Start,
    /// Middle of the text.
    Middle,
    /// End of the text.
    End,
}

impl Drawing {
    /// Makes an empty drawing.
    pub fn new(width: f64, height: f64) -> Drawing {
        Drawing { body: String::new(), width, height }
    }

    /// Increases the height.
    pub(crate) fn grow(&mut self, height: f64) {
        self.height = self.height.max(height);
    }

    /// Adds an element of a class with lengths as attributes.
    fn element(&mut self, name: &str, class: &str, lengths: &[(&str, f64)]) {
        let lengths: String = lengths.iter().map(|(key, length)| format!(r#" {key}="{}""#, short(*length))).collect();
        let _ = write!(self.body, r#"<{name} class="{class}"{lengths}/>"#);
    }

    /// Adds a straight line.
    pub fn line(&mut self, class: &str, from: [f64; 2], to: [f64; 2]) {
        self.element("line", class, &[("x1", from[0]), ("y1", from[1]), ("x2", to[0]), ("y2", to[1])]);
    }

    /// Adds a rectangle by two opposite corners.
    pub fn rectangle(&mut self, class: &str, a: [f64; 2], b: [f64; 2]) {
        let [x, y] = [0, 1].map(|axis| a[axis].min(b[axis]));
        let [width, height] = [0, 1].map(|axis| (a[axis] - b[axis]).abs());
        self.element("rect", class, &[("x", x), ("y", y), ("width", width), ("height", height)]);
    }

    fn circle(&mut self, class: &str, centre: [f64; 2], radius: f64) {
        self.element("circle", class, &[("cx", centre[0]), ("cy", centre[1]), ("r", radius)]);
    }

    /// Adds an open curve through points; points that are not finite interrupt it.
    pub(crate) fn curve(&mut self, class: &str, points: impl Iterator<Item = [f64; 2]>) {
        let mut data = String::new();
        let mut pen_down = false;
        for [x, y] in points {
            if !(x.is_finite() && y.is_finite()) {
                pen_down = false;
                continue;
            }
            let _ = write!(data, "{}{} {}", if pen_down { "L" } else { "M" }, short(x), short(y));
            pen_down = true;
        }
        if !data.is_empty() {
            let _ = write!(self.body, r#"<path class="{class}" d="{data}"/>"#);
        }
    }

    /// Adds a text of a class at a position.
    pub fn text(&mut self, class: &str, at: [f64; 2], anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let _ = write!(
            self.body,
            r#"<text class="{class}" x="{}" y="{}" text-anchor="{anchor}">{}</text>"#,
            short(at[0]),
            short(at[1]),
            escape(text),
        );
    }

    /// Adds a text that reads upwards, for the label of a vertical axis.
    pub(crate) fn text_upwards(&mut self, class: &str, at: [f64; 2], text: &str) {
        let (x, y) = (short(at[0]), short(at[1]));
        let _ = write!(
            self.body,
            r#"<text class="{class}" transform="translate({x} {y}) rotate(-90)" text-anchor="middle">{}</text>"#,
            escape(text),
        );
    }

    /// Adds the marker of a code; hollow markers show results that are not live.
    pub fn marker(&mut self, style: CodeStyle, at: [f64; 2], size: f64, hollow: bool) {
        let class = format!("{} {}", style.class, if hollow { "hollow" } else { "marker" });
        let [x, y] = at;
        match style.marker {
            Marker::Circle => self.circle(&class, at, size),
            Marker::Square => {
                let half = size * 0.9;
                self.rectangle(&class, [x - half, y - half], [x + half, y + half]);
            }
            Marker::Triangle => self.polygon(
                &class,
                &[[x, y - size * 1.2], [x + size * 1.1, y + size * 0.8], [x - size * 1.1, y + size * 0.8]],
            ),
            Marker::Wedge => self.polygon(
                &class,
                &[[x, y + size * 1.2], [x + size * 1.1, y - size * 0.8], [x - size * 1.1, y - size * 0.8]],
            ),
            Marker::Cross => {
                // Two crossed bars; `arm` is their half length along the axes, `half` their half width.
                let (arm, half) = (size * 1.05, size * 0.38);
                let quarter = [[half, 0.0], [arm, arm - half], [arm - half, arm], [0.0, half]];
                let turns: [fn([f64; 2]) -> [f64; 2]; 4] =
                    [|p| p, |[a, b]| [-b, a], |[a, b]| [-a, -b], |[a, b]| [b, -a]];
                let corners = turns.iter().flat_map(|turn| quarter.map(turn));
                let corners: Vec<[f64; 2]> = corners.map(|[a, b]| [x + a, y + b]).collect();
                self.polygon(&class, &corners);
            }
            Marker::Diamond => {
                let half = size * 1.25;
                self.polygon(&class, &[[x, y - half], [x + half, y], [x, y + half], [x - half, y]]);
            }
        }
    }

    /// Adds a closed polygon.
    pub fn polygon(&mut self, class: &str, points: &[[f64; 2]]) {
        let points: Vec<String> = points.iter().map(|p| format!("{},{}", short(p[0]), short(p[1]))).collect();
        let _ = write!(self.body, r#"<polygon class="{class}" points="{}"/>"#, points.join(" "));
    }

    /// Clips the drawing from here to [`Drawing::end_clip`] at a rectangle.
    pub(crate) fn begin_clip(&mut self, corner: [f64; 2], width: f64, height: f64) {
        // A nested viewport clips without an id, which would have to be unique on the page.
        let _ = write!(
            self.body,
            r#"<svg x="{x}" y="{y}" width="{w}" height="{h}" viewBox="{x} {y} {w} {h}">"#,
            x = short(corner[0]),
            y = short(corner[1]),
            w = short(width),
            h = short(height),
        );
    }

    /// Ends a clipped part.
    pub(crate) fn end_clip(&mut self) {
        self.body.push_str("</svg>");
    }

    /// Returns the drawing, with a name for readers who cannot see it.
    pub fn finish(self, name: &str) -> String {
        format!(
            r#"<svg role="img" aria-label="{}" viewBox="0 0 {} {}" style="max-width:{}px">{}</svg>"#,
            escape(name),
            short(self.width),
            short(self.height),
            short(self.width),
            self.body,
        )
    }
}

/// Returns a finished drawing as a file of its own, with the styles of a page.
pub fn standalone(drawing: &str) -> String {
    let head = r#"<svg xmlns="http://www.w3.org/2000/svg" "#;
    let style = format!(
        "<style>{}svg {{ background: var(--paper); font-family: sans-serif; }}</style>",
        include_str!("figure.css")
    );
    let inside = drawing.find('>').map_or(drawing.len(), |end| end + 1);
    let (open, body) = drawing.split_at(inside);
    format!("{head}{}{style}{body}\n", open.trim_start_matches("<svg "))
}

/// Formats a coordinate to a tenth of a pixel, without needless digits.
fn short(value: f64) -> String {
    let text = format!("{value:.1}");
    match text.strip_suffix(".0") {
        Some("-0") => "0".into(),
        Some(whole) => whole.into(),
        None => text,
    }
}

/// Escapes a text for XML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
