//! Names of scenes, walls and materials: they stand in messages, tables and names of files, so that they have to be fit for these.

use super::Scene;
use super::document_path::{Checked, DocumentPath};
use super::error::is_printable;
use std::collections::HashMap;

/// Longest name, bytes: names of files have 255, and more is put beside a scene's name in them.
const LONGEST: usize = 100;

/// Names of columns that a driven wall adds to the table of observables begin with its own. This one is taken, by the observable.
const TAKEN: &str = "driven_wall";

/// Checks the scene's names, and that no two things have one name.
pub(super) fn check(scene: &Scene) -> Checked {
    let root = DocumentPath::default();
    let at = root.key("name");
    fit(&at, "the scene's name", &scene.name)?;
    if scene.name.contains(['/', '\\']) || scene.name == "." || scene.name == ".." {
        let problem = format!("'{}' does not name a folder of results", scene.name);
        return Err(at.fault(problem, "give a name without '/' and '\\', other than '.' and '..'"));
    }
    if let Some(odd) = scene.description.chars().find(|&c| !is_printable(c) && !matches!(c, '\n' | '\r' | '\t')) {
        let problem = format!("has the character {}, which does not show", odd.escape_unicode());
        return Err(root.key("description").fault(problem, "leave it out"));
    }
    for name in scene.material.keys() {
        fit(&root.key("material"), "a material's name", name)?;
    }
    let mut walls = HashMap::new();
    for (index, wall) in scene.wall.iter().enumerate() {
        let at = root.key("wall").index(index).key("name");
        fit(&at, "a wall's name", &wall.name)?;
        if let Some(before) = walls.insert(&wall.name, index) {
            let problem = format!("'{}' is the name of wall[{before}] too", wall.name);
            return Err(at.fault(problem, "give each wall a name of its own: tables tell them apart by it"));
        }
        if wall.name == TAKEN && wall.motion.is_driven() {
            let problem =
                format!("the columns of a driven wall '{TAKEN}' would be those of the observable driven-wall");
            return Err(at.fault(problem, "give the wall another name"));
        }
    }
    let mut pairs = HashMap::new();
    for (index, rule) in scene.pair.iter().enumerate() {
        let [a, b] = &rule.between;
        if let Some(before) = pairs.insert((a.min(b), a.max(b)), index) {
            let at = root.key("pair").index(index).key("between");
            let problem = format!("pair[{before}] is a rule of '{a}' and '{b}' already");
            return Err(at.fault(problem, "say in one rule all that holds for the two, in any order"));
        }
    }
    Ok(())
}

/// Whether a name can be shown, put into a table and made a file's.
fn fit(at: &DocumentPath, whose: &str, name: &str) -> Checked {
    let refuse = |what: String, remedy: &str| Err(at.fault(format!("{whose} {what}"), remedy));
    if name.trim().is_empty() {
        return refuse("is empty".into(), "give a name");
    }
    if name.len() > LONGEST {
        let start: String = name.chars().take(20).collect();
        return refuse(
            format!("'{start}...' is {} bytes long", name.len()),
            &format!("give a name of at most {LONGEST} bytes"),
        );
    }
    if let Some(odd) = name.chars().find(|&c| !is_printable(c)) {
        return refuse(format!("has the character {}, which does not show", odd.escape_unicode()), "leave it out");
    }
    if name.starts_with(['=', '+', '-', '@']) {
        return refuse(
            format!("'{name}' begins as a formula does"),
            "begin with another character: programs for tables would compute it",
        );
    }
    Ok(())
}
