//! All cases of a law over all seeds, side by side; each row is kept as soon as it is there, and taken up by the next start.

use super::{Case, Law, LawError, Row, Run};
use crate::provenance::{JUDGE, VERSION, scene_hash};
use crate::study::{Key, RunCache};
use makadam::BUILD;
use rayon::prelude::*;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// What is to be run.
pub(crate) struct Plan<'a> {
    /// Seeds of each case.
    pub(crate) seeds: &'a [u64],
    /// Whether rows that an earlier start has kept are measured again.
    pub(crate) again: bool,
    /// Folder of the law.
    pub(crate) folder: &'a Path,
}

/// Measures every case with every seed; rows are in the order of the cases, and of the seeds within a case. `progress` is told
/// the share that is done.
///
/// # Errors
/// [`LawError`] of the first run that fails.
pub(crate) fn carry_out(
    law: &'static dyn Law,
    cases: &[Case],
    plan: &Plan<'_>,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Row>, LawError> {
    let kept = KeptRows::open(law, plan)?;
    let runs: Vec<(&Case, u64)> =
        cases.iter().flat_map(|case| plan.seeds.iter().map(move |&seed| (case, seed))).collect();
    let weights: Vec<f64> = runs.iter().map(|(case, _)| work(case)).collect();
    let total: f64 = weights.iter().sum();
    let shares: Vec<AtomicU64> = runs.iter().map(|_| AtomicU64::new(0)).collect();
    let one = |number: usize| -> Result<Row, LawError> {
        let (case, seed) = runs[number];
        let told = |share: f64| {
            shares[number].store(share.to_bits(), Ordering::Relaxed);
            let done = shares.iter().map(|share| f64::from_bits(share.load(Ordering::Relaxed)));
            progress(done.zip(&weights).map(|(share, weight)| share * weight).sum::<f64>() / total);
        };
        let row = kept.take(case, seed, &told)?;
        told(1.0);
        Ok(row)
    };
    // The longest first, so that none is left alone at the end.
    let mut order: Vec<usize> = (0..runs.len()).collect();
    order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]));
    let rows: Result<Vec<(usize, Row)>, LawError> =
        order.into_par_iter().with_max_len(1).map(|number| Ok((number, one(number)?))).collect();
    let mut rows = rows?;
    rows.sort_by_key(|(number, _)| *number);
    Ok(rows.into_iter().map(|(_, row)| row).collect())
}

/// Rows of a law, each measured where it is not kept.
pub(crate) struct KeptRows {
    law: &'static dyn Law,
    cache: RunCache,
    again: bool,
}

impl KeptRows {
    /// Those of a plan.
    ///
    /// # Errors
    /// [`LawError`] if its folder cannot be made.
    pub(crate) fn open(law: &'static dyn Law, plan: &Plan<'_>) -> Result<KeptRows, LawError> {
        Ok(KeptRows { law, cache: RunCache::open(&plan.folder.join("runs"))?, again: plan.again })
    }

    /// The row of a case and a seed; `progress` is told the share of its run that is done.
    ///
    /// # Errors
    /// [`LawError`] if it has to be measured and cannot.
    pub(crate) fn take(&self, case: &Case, seed: u64, progress: &(dyn Fn(f64) + Sync)) -> Result<Row, LawError> {
        self.cache.take(&key(case, seed), self.again, || measured(self.law, case, seed, progress))
    }
}

/// Grains times steps.
pub(crate) fn work(case: &Case) -> f64 {
    let grains: usize = case.scene.population.iter().map(|population| population.count).sum();
    (grains + case.scene.grain.len()) as f64 * case.scene.duration / case.scene.solver.step
}

/// What a row follows from: the scene, the seed, the build, and the sources that measure.
fn key(case: &Case, seed: u64) -> Key {
    Key::new(format!("{}-s{seed}", case.name), &[&hash(case), &seed.to_string(), BUILD, JUDGE])
}

fn measured(law: &dyn Law, case: &Case, seed: u64, progress: &(dyn Fn(f64) + Sync)) -> Result<Row, LawError> {
    let start = Instant::now();
    let mut run = Run::start(case, seed, progress)?;
    let mut values = law.measure(case, &mut run)?;
    values.extend(case.given.clone());
    Ok(Row {
        case: case.name.clone(),
        seed,
        values,
        scene_hash: hash(case),
        makadam: VERSION.into(),
        grains: run.frame().particles.len(),
        steps: run.steps(),
        wall_seconds: start.elapsed().as_secs_f64(),
    })
}

/// Hash of a case's scene, 16 hexadecimal digits.
pub(super) fn hash(case: &Case) -> String {
    format!("{:016x}", scene_hash(&case.scene))
}
