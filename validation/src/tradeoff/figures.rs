//! Error against wall time: one figure an observable and a stiffness for the codes, and one for each kind of variation of
//! Makadam's solver.

use super::front::pareto_front;
use super::panel::{Member, Series, bound_of, noise_of, panel};
use super::rows::{Point, Reference};
use super::study::Study;
use super::variations::{Family, Variation};
use super::words::modulus;
use crate::draw::figure::Figure;
use crate::draw::names::{CodeStyle, Marker, code_style, observable};
use crate::output::file_stem;

/// Observables that have a figure at the scene's stiffness; at others only bounded ones have.
const SHOWN: usize = 4;

/// Figures of the scene's stiffness first, with the variations of the solver, then the bounded observables at the others.
pub(super) fn figures(study: &Study) -> Vec<Figure> {
    let mut factors = study.stiffness_factors();
    factors.sort_by(|a, b| (*a != 1.0).cmp(&(*b != 1.0)).then(a.total_cmp(b)));
    let mut all = Vec::new();
    for factor in factors {
        let room = if factor == 1.0 { SHOWN.max(study.bounds.len()) } else { study.bounds.len() };
        for name in study.observables().into_iter().take(room) {
            all.extend(study.reference(name, factor).and_then(|reference| codes(study, reference)));
        }
        if factor == 1.0 {
            // Without a bound the first observable stands for all.
            for name in study.observables().into_iter().take(study.bounds.len().max(1)) {
                let reference = study.reference(name, factor);
                all.extend(reference.into_iter().flat_map(|reference| variations(study, reference)));
            }
        }
    }
    all
}

/// All codes on one observable at one stiffness; absent where no point has an error.
fn codes(study: &Study, reference: &Reference) -> Option<Figure> {
    let name = reference.observable.as_str();
    let of = |point: &&Point| point.stiffness_factor == reference.stiffness_factor && !point.reference;
    let all: Vec<&Point> = study.points.iter().filter(of).collect();
    let mut names: Vec<&str> = Vec::new();
    for point in &all {
        if !names.contains(&point.code.as_str()) {
            names.push(&point.code);
        }
    }
    let mut series: Vec<Series<'_>> = Vec::new();
    for code in &names {
        let own: Vec<&Point> = all.iter().copied().filter(|point| point.code == *code).collect();
        let (varied, plain): (Vec<&Point>, Vec<&Point>) = own.iter().partition(|point| point.variation.is_some());
        series.push(Series {
            name: code,
            style: code_style(code),
            members: members_of(&plain, name),
            cut: cut_of(&plain),
            // A code has one front, whatever its settings.
            front: members_of(&own, name).into_iter().filter(|member| member.deviation.on_front).collect(),
            labelled: true,
        });
        if !varied.is_empty() {
            series.push(Series {
                name: "Makadam, solver varied",
                style: CodeStyle { class: code_style(code).class, marker: Marker::Cross },
                members: members_of(&varied, name),
                cut: cut_of(&varied),
                front: Vec::new(),
                labelled: false,
            });
        }
    }
    let stiffness = modulus(reference.youngs_modulus);
    let about = format!("Error of the {} against wall time, grains of {stiffness}", observable(name));
    Some(Figure {
        name: format!("{}-{}", file_stem(name), file_stem(&stiffness.replace(' ', ""))),
        svg: panel(study, reference, series, &about)?,
        caption: format!(
            "{about}. Lines are Pareto fronts, bars one standard error over seeds; points at the lower edge lie below it. \
             The numbered settings are named below the plot."
        ),
    })
}

/// Makadam's sweeps beside their variations, one figure a kind of variation; none where none of a kind has an error.
fn variations(study: &Study, reference: &Reference) -> Vec<Figure> {
    let name = reference.observable.as_str();
    let own = |point: &&Point| {
        point.code == "Makadam" && point.stiffness_factor == reference.stiffness_factor && !point.reference
    };
    let family = |point: &Point| point.variation.as_deref().and_then(Variation::named).map(|known| known.family);
    let floor = noise_of(study, reference);
    let series = |of: Option<Family>| {
        let points: Vec<&Point> = study.points.iter().filter(own).filter(|point| family(point) == of).collect();
        let members = members_of(&points, name);
        let coordinates: Vec<[f64; 2]> = members.iter().map(Member::coordinates).collect();
        Series {
            name: of.map_or("sweeps", Family::name),
            style: of.map_or(code_style("Makadam"), Family::style),
            front: pareto_front(&coordinates, floor).into_iter().map(|place| members[place]).collect(),
            cut: cut_of(&points),
            members,
            labelled: of.is_none(),
        }
    };
    let stiffness = modulus(reference.youngs_modulus);
    let figure = |(kind, families): (&str, &[Family])| {
        let varied: Vec<Series<'_>> =
            families.iter().map(|family| series(Some(*family))).filter(|series| !series.is_empty()).collect();
        if varied.is_empty() {
            return None;
        }
        let all = std::iter::once(series(None)).chain(varied).collect();
        let about =
            format!("Error of the {} against wall time, {kind} of Makadam, grains of {stiffness}", observable(name));
        Some(Figure {
            name: format!("{}-{}", file_stem(name), kind.replace(", ", "-").replace(' ', "-")),
            svg: panel(study, reference, all, &about)?,
            caption: format!(
                "{about}. Sweeps are Gauss-Seidel in double precision with over-relaxation and warm start; lines are the Pareto \
                 front of each kind. The numbered settings are named below the plot."
            ),
        })
    };
    let bounded = bound_of(study, name).is_some() || study.bounds.is_empty();
    Family::PANELS.into_iter().filter(|_| bounded).filter_map(figure).collect()
}

/// Points with an error.
fn members_of<'a>(points: &[&'a Point], name: &str) -> Vec<Member<'a>> {
    let member = |point: &&'a Point| Some(Member { point, deviation: point.deviation(name)? });
    points.iter().filter_map(member).collect()
}

/// Points that were cut short.
fn cut_of<'a>(points: &[&'a Point]) -> Vec<&'a Point> {
    points.iter().copied().filter(|point| point.extrapolated).collect()
}
