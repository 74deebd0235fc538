//! Gauss-Seidel with Anderson's acceleration.
//!
//! After D. G. Anderson, *Iterative procedures for nonlinear integral equations*, Journal of the ACM 12 (1965), in the form of H. F.
//! Walker and P. Ni, SIAM Journal on Numerical Analysis 49 (2011). With a sweep G and its change `F_j = G(x_j) - x_j`,
//!
//! ```text
//! x_k+1 = sum_j c_j G(x_j)     c minimises |sum_j c_j F_j|, sum_j c_j = 1, over the last m + 1 sweeps
//! ```
//!
//! Changes are weighed by their kinetic energy, that is by the velocities that go with them. This is the norm of the operator
//! without compliance, it makes grains of any mass comparable, and it needs no vector over contacts. An iteration extrapolates
//! first and then sweeps, so that it leaves impulses inside their cones.
//!
//! The map is not smooth, so an extrapolation may lead astray. Where the sweep after it changes more than the last one did by
//! more than half, it is taken back: the iteration sweeps again from where the last one ended, without over-relaxation
//! from then on, and the memory starts anew.

use super::gauss_seidel::OverRelaxation;
use super::problem::State;
use super::velocities::MOST;
use super::{Method, Problem};
use crate::sweep::{ResidualLevel, Residuals};
use crate::world::Body;

/// A sweep's residual over the last one's from which an extrapolation is taken back.
const SAFEGUARD: f64 = 1.5;

/// Share of each diagonal entry that is added to it: the changes of late sweeps are nearly dependent.
const REGULARISATION: f64 = 1e-12;

/// Anderson's acceleration.
#[derive(Clone, Debug)]
pub(super) struct Anderson {
    factor: OverRelaxation,
    /// Results of the last sweeps, in a ring.
    swept: Vec<State>,
    /// Changes of velocities by the same sweeps.
    changes: Vec<Vec<Body>>,
    /// Products of the changes, J.
    products: [[f64; MOST]; MOST],
    /// Place of the last sweep in the ring, and how many are remembered.
    newest: usize,
    remembered: usize,
    /// Residual of the last sweep, m/s.
    last: f64,
    /// Velocities where a sweep begins.
    before: Vec<Body>,
}

impl Anderson {
    /// With so many earlier sweeps remembered, at most [`MOST_MEMORY`](crate::scene::MOST_MEMORY).
    pub fn new(memory: u32) -> Anderson {
        let slots = (memory as usize + 1).min(MOST);
        Anderson {
            factor: OverRelaxation::default(),
            swept: vec![State::default(); slots],
            changes: vec![Vec::new(); slots],
            products: [[0.0; MOST]; MOST],
            newest: 0,
            remembered: 0,
            last: f64::INFINITY,
            before: Vec::new(),
        }
    }

    /// Sweeps from the present state and remembers what that did.
    fn sweep(&mut self, problem: &mut Problem<'_>) -> Option<Residuals> {
        self.before.copy_from_slice(problem.bodies);
        problem.sweep(self.factor.value, ResidualLevel::Directions)
    }

    fn remember(&mut self, problem: &mut Problem<'_>) {
        let slots = self.swept.len();
        self.newest = (self.newest + 1) % slots;
        self.remembered = (self.remembered + 1).min(slots);
        problem.keep(&mut self.swept[self.newest]);
        problem.velocity_change(&self.before, &mut self.changes[self.newest]);
        let mut others: [&[Body]; MOST] = [&[]; MOST];
        for (age, other) in others[..self.remembered].iter_mut().enumerate() {
            *other = &self.changes[(self.newest + slots - age) % slots];
        }
        let products = problem.products(&self.changes[self.newest], &others[..self.remembered]);
        for (age, product) in products[..self.remembered].iter().enumerate() {
            let slot = (self.newest + slots - age) % slots;
            (self.products[self.newest][slot], self.products[slot][self.newest]) = (*product, *product);
        }
    }

    /// The present state becomes the best combination of what sweeps left; false where there is none but the last.
    fn extrapolate(&mut self, problem: &mut Problem<'_>) -> bool {
        let (slots, count) = (self.swept.len(), self.remembered);
        let slot = |age: usize| (self.newest + slots - age) % slots;
        let mut matrix = [[0.0; MOST]; MOST];
        for (row, entries) in matrix[..count].iter_mut().enumerate() {
            for (column, entry) in entries[..count].iter_mut().enumerate() {
                *entry = self.products[slot(row)][slot(column)];
            }
        }
        let Some(coefficients) = weights(matrix, count) else { return false };
        let mut states: [&State; MOST] = [&self.swept[self.newest]; MOST];
        for (age, state) in states[..count].iter_mut().enumerate() {
            *state = &self.swept[slot(age)];
        }
        problem.combine(&coefficients[..count], &states[..count]);
        true
    }
}

/// Weights c with sum one that minimise `c.A c`: `A z = 1`, `c = z / sum z`, by Cholesky. Absent where A is not positive or
/// there is nothing to weigh.
fn weights(mut a: [[f64; MOST]; MOST], count: usize) -> Option<[f64; MOST]> {
    if count < 2 {
        return None;
    }
    let mut z = [1.0; MOST];
    for i in 0..count {
        a[i][i] *= 1.0 + REGULARISATION;
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| a[i][k] * a[j][k]).sum();
            let rest = a[i][j] - known;
            if i != j {
                a[i][j] = rest / a[j][j];
            } else if rest > 0.0 {
                a[i][i] = rest.sqrt();
            } else {
                return None;
            }
        }
        let known: f64 = (0..i).map(|k| a[i][k] * z[k]).sum();
        z[i] = (z[i] - known) / a[i][i];
    }
    for i in (0..count).rev() {
        let known: f64 = (i + 1..count).map(|k| a[k][i] * z[k]).sum();
        z[i] = (z[i] - known) / a[i][i];
    }
    let sum: f64 = z[..count].iter().sum();
    let usable = sum > 0.0 && z[..count].iter().all(|weight| weight.is_finite());
    usable.then(|| z.map(|weight| weight / sum))
}

impl Method for Anderson {
    fn begin(&mut self, problem: &mut Problem<'_>) {
        problem.number_groups();
        self.factor.begin(problem.settings.over_relaxation);
        for (state, change) in self.swept.iter_mut().zip(&mut self.changes) {
            state.fit(problem);
            change.clear();
            change.extend_from_slice(problem.bodies);
        }
        self.before.clear();
        self.before.extend_from_slice(problem.bodies);
        (self.newest, self.remembered, self.last) = (0, 0, f64::INFINITY);
    }

    fn iterate(&mut self, problem: &mut Problem<'_>, _: ResidualLevel) -> Option<Residuals> {
        let extrapolated = self.extrapolate(problem);
        let mut residuals = self.sweep(problem)?;
        if extrapolated && residuals.rms() > SAFEGUARD * self.last {
            problem.combine(&[1.0], &[&self.swept[self.newest]]);
            self.factor.fall_back();
            self.remembered = 0;
            residuals = self.sweep(problem)?;
        }
        self.remember(problem);
        self.last = residuals.rms();
        Some(residuals)
    }

    fn fell_back(&self) -> bool {
        self.factor.fell_back
    }

    fn memory_bytes(&self) -> usize {
        let changes: usize = self.changes.iter().map(Vec::capacity).sum();
        self.swept.iter().map(State::memory_bytes).sum::<usize>()
            + (changes + self.before.capacity()) * size_of::<Body>()
    }
}
