//! What a reader of a verdict must know of the frames that a code has left.

use crate::compare::Harvest;

/// The notes of the runs of a code, each once, with the seeds that it is of.
pub(super) fn reading_notes(code: &str, harvests: &[Harvest]) -> Vec<String> {
    let mut known: Vec<(&str, Vec<u64>)> = Vec::new();
    for harvest in harvests {
        for note in &harvest.notes {
            match known.iter_mut().find(|(text, _)| text == note) {
                Some((_, seeds)) => seeds.push(harvest.run.seed),
                None => known.push((note, vec![harvest.run.seed])),
            }
        }
    }
    let sentence = |(note, seeds): (&str, Vec<u64>)| match &seeds[..] {
        [seed] => format!("{code}, seed {seed}: {note}"),
        all if all.len() == harvests.len() => format!("{code}, all {} seeds: {note}", all.len()),
        some => {
            let some: Vec<String> = some.iter().map(ToString::to_string).collect();
            format!("{code}, seeds {}: {note}", some.join(", "))
        }
    };
    known.into_iter().map(sentence).collect()
}
