//! What a reader of a verdict must know of the runs of a code.

use super::Harvest;

/// In sentences, what watchdogs noticed on the runs of a code, and what had to be assumed of their frames: each assumption once, with the
/// seeds that it is of.
pub fn noticed(code: &str, harvests: &[Harvest]) -> Vec<String> {
    let alarms_of = |harvest: &Harvest| {
        let seed = harvest.run.seed;
        harvest.alarms.iter().map(|alarm| format!("{code}, seed {seed}: {}", alarm.words())).collect::<Vec<_>>()
    };
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
    harvests.iter().flat_map(alarms_of).chain(known.into_iter().map(sentence)).collect()
}
