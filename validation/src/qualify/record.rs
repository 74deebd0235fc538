//! The tests that a qualification makes, on record: one that is lost would make it pass more easily.

use super::tier::Tier;
use crate::report::{StudyTestOnRecord, TestOnRecord};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// Each test with the first tier that makes it, its margin, its seeds and the hash of its scene; a test is taken off, made wider, given fewer
/// seeds or another scene here or not at all.
const TESTS: &str = include_str!("tests.csv");

/// The same of the tests of studies.
const STUDIES: &str = include_str!("studies.csv");

/// The recorded numbers of each scene and peer that a tier judges by, as hashes: others are recorded by an edit here too.
const REFERENCES: &str = include_str!("references.csv");

/// A line of `references.csv`.
#[derive(Deserialize)]
struct ReferenceLine {
    scene: String,
    code: String,
    fingerprint: String,
}

/// Hash of what is on record of a peer on a scene ([`CodeRuns::fingerprint`](crate::compare::CodeRuns::fingerprint)).
pub(super) fn fingerprint_on_record(scene: &str, code: &str) -> Option<String> {
    let is_this = |line: &ReferenceLine| (line.scene.as_str(), line.code.as_str()) == (scene, code);
    lines::<ReferenceLine>(REFERENCES).into_iter().find(is_this).map(|line| line.fingerprint)
}

/// A line of `tests.csv`.
#[derive(Deserialize)]
struct Line {
    tier: Tier,
    scene: String,
    observable: String,
    reference_code: String,
    margin: f64,
    seeds: usize,
    judged_seeds: usize,
    scene_hash: String,
}

/// A line of `studies.csv`.
#[derive(Deserialize)]
struct StudyLine {
    tier: Tier,
    study: String,
    test: String,
    known_exception: bool,
}

/// The tests of equivalence on record of a tier: its own, and those of the tiers before it.
pub fn on_record(tier: Tier) -> Vec<TestOnRecord> {
    let own = lines::<Line>(TESTS).into_iter().filter(|line| line.tier <= tier);
    own.map(|line| TestOnRecord {
        scene: line.scene,
        observable: line.observable,
        reference_code: line.reference_code,
        margin: Some(line.margin),
        seeds: line.seeds,
        judged_seeds: line.judged_seeds,
        scene_hash: Some(line.scene_hash),
    })
    .collect()
}

/// The tests of studies on record of a tier.
pub fn studies_on_record(tier: Tier) -> Vec<StudyTestOnRecord> {
    let own = lines::<StudyLine>(STUDIES).into_iter().filter(|line| line.tier <= tier);
    own.map(|StudyLine { study, test, known_exception, .. }| StudyTestOnRecord { study, test, known_exception })
        .collect()
}

fn lines<T: DeserializeOwned>(table: &str) -> Vec<T> {
    let mut table = csv::Reader::from_reader(table.as_bytes());
    table.deserialize().collect::<Result<_, _>>().expect("a test holds the record to its form")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::Reference;
    use crate::peers::{CodeName, codes_of};
    use crate::problem::RECORDED;
    use crate::qualify::tier::{Study, TIERS};
    use crate::scenes::find;
    use crate::stability::{KNOWN_EXCEPTIONS, catalogue};
    use clap::ValueEnum;

    #[test]
    fn the_record_names_each_test_once_a_tier() {
        for (tier, count) in [(Tier::Quick, 45), (Tier::Full, 109), (Tier::Release, 139)] {
            let all = on_record(tier);
            assert_eq!(all.len(), count);
            let named = |test: &TestOnRecord| (test.to_string(), test.judged_seeds);
            let names: Vec<_> = all.iter().map(named).collect();
            assert!((1..all.len()).all(|place| !names[..place].contains(&names[place])));
            assert!(all.iter().all(|test| test.margin.is_some_and(|margin| margin > 0.0) && test.seeds >= 4));
        }
    }

    /// Where references were recorded anew on purpose, the lines that this test shows are those of `references.csv`.
    #[test]
    fn the_recorded_numbers_are_those_on_record() {
        let mut now = String::from("scene,code,fingerprint\n");
        for scene in Tier::Release.extent().scenes {
            let reference = Reference::of_scene(&find(scene, &[]).unwrap()).unwrap().unwrap();
            for code in codes_of(CodeName::value_variants()).iter().map(|code| code.name()) {
                let recorded = reference.code(code).map(|runs| format!("{scene},{code},{}\n", runs.fingerprint()));
                now += &recorded.unwrap_or_default();
            }
        }
        assert_eq!(REFERENCES, now, "{now}");
        let mut runs = Reference::of_scene(&find("packing", &[]).unwrap()).unwrap().unwrap().code("YADE").unwrap();
        let on_record = fingerprint_on_record("packing", "YADE");
        runs.runs[3].measurements[0].value *= 1.0 + 1e-12;
        assert!(on_record.is_some() && on_record != Some(runs.fingerprint()));
        assert_eq!(fingerprint_on_record("drum-100k", "YADE"), None);
    }

    #[test]
    fn each_tier_has_on_record_what_the_table_says() {
        for extent in &TIERS {
            let tier = extent.on_record.expect("every tier has a record");
            let (tests, studies) = (on_record(tier), studies_on_record(tier));
            for scene in extent.scenes {
                let own = || tests.iter().filter(|test| test.scene == *scene);
                assert!(own().count() > 0, "{scene} in {}", extent.name);
                let asked = extent.fewest_seeds as usize;
                assert!(own().any(|test| test.seeds.max(test.judged_seeds) >= asked), "{scene} in {}", extent.name);
            }
            let mut named: Vec<&str> = studies.iter().map(|test| test.study.as_str()).collect();
            named.dedup();
            assert_eq!(named, extent.studies.iter().map(Study::name).collect::<Vec<_>>(), "{}", extent.name);
            for study in extent.studies {
                let own: Vec<&str> =
                    studies.iter().filter(|test| test.study == study.name()).map(|test| test.test.as_str()).collect();
                match study {
                    Study::HardCases(_) => {
                        assert_eq!(own, catalogue().iter().map(|case| case.name.clone()).collect::<Vec<_>>());
                    }
                    Study::Laws(laws) => {
                        let of = |name: &str| own.iter().any(|test| test.starts_with(&format!("{name}: ")));
                        assert!(laws.iter().all(|(name, _)| of(name)));
                    }
                    Study::Ablation(scenes) => {
                        let tests = scenes.iter().flat_map(|ablated| {
                            let needed =
                                ablated.needed.iter().map(move |effect| format!("{}: {effect}", ablated.scene));
                            std::iter::once(format!("{}: as it is", ablated.scene)).chain(needed)
                        });
                        assert_eq!(own, tests.collect::<Vec<_>>());
                    }
                    Study::ContactProblems => {
                        let tests = RECORDED.iter().flat_map(|problem| {
                            ["direct", "lanes", "siconos"].map(|solver| format!("{}: {solver}", problem.name))
                        });
                        assert_eq!(own, tests.collect::<Vec<_>>());
                    }
                    Study::Convergence(scenes) => {
                        let of = |name: &str| own.iter().any(|test| test.starts_with(&format!("{name}: ")));
                        assert!(scenes.iter().all(|scene| of(scene)));
                    }
                    Study::Tradeoff(scenes) => {
                        let judged = own.iter().map(|test| test.split_once(": ").map_or(*test, |(scene, _)| scene));
                        assert!(judged.eq(scenes.iter().map(|(scene, _)| *scene)));
                    }
                }
            }
        }
    }

    #[test]
    fn known_exceptions_are_few_and_those_that_the_studies_list() {
        let known = studies_on_record(Tier::Release).into_iter().filter(|test| test.known_exception);
        let known: Vec<(String, String)> = known.map(|test| (test.study, test.test)).collect();
        let of = |study: &str, test: &str| (study.to_string(), test.to_string());
        let hard = known.iter().filter(|(study, _)| study == "stability").map(|(_, test)| test.as_str());
        assert_eq!(hard.collect::<Vec<_>>(), KNOWN_EXCEPTIONS.map(|(name, _)| name));
        let expected =
            [of("stability", "impossible-gap-rigid"), of("convergence", "drum: projected-conjugate-gradients")];
        assert_eq!(known, expected);
    }
}
