//! Gauss-Seidel with Anderson acceleration.
//!
//! Method of D. G. Anderson, *Iterative procedures for nonlinear integral equations*, Journal of the ACM 12 (1965), in the form
//! of H. F. Walker and P. Ni, SIAM Journal on Numerical Analysis 49 (2011). With a sweep G and its change `F_j = G(x_j) - x_j`,
//!
//! ```text
//! x_k+1 = sum_j c_j G(x_j)     c minimises |sum_j c_j F_j|, sum_j c_j = 1, over the last m + 1 sweeps
//! ```
//!
//! The weight of a change is its kinetic energy, computed from the corresponding velocities. This is the norm of the operator
//! without compliance; grains of any mass become comparable, and no vector over contacts is needed. An iteration extrapolates
//! first and then sweeps, so that impulses end inside their cones.
//!
//! The map is not smooth, so an extrapolation may fail. If the next sweep's change exceeds 1.5 times that of the last sweep, the
//! extrapolation is reverted: the iteration sweeps again from the end of the last one, without over-relaxation from then on, and
//! the memory is cleared.

use super::gauss_seidel::OverRelaxation;
use super::problem::State;
use super::velocities::MOST;
use super::{Method, Problem};
use crate::sweep::{ResidualLevel, Residuals};
use crate::world::Body;

/// Ratio of successive sweep residuals above which an extrapolation is reverted.
const SAFEGUARD: f64 = 1.5;

/// Relative increase of each diagonal entry: the changes of late sweeps are nearly dependent.
const REGULARISATION: f64 = 1e-12;

/// Anderson acceleration.
#[derive(Clone, Debug)]
pub(super) struct Anderson {
    factor: OverRelaxation,
    /// Results of the last sweeps, in a ring buffer.
    swept: Vec<State>,
    /// Changes of velocities by the same sweeps.
    changes: Vec<Vec<Body>>,
    /// Products of the changes, J.
    products: [[f64; MOST]; MOST],
    /// Index of the last sweep in the ring buffer, and number of stored sweeps.
    newest: usize,
    remembered: usize,
    /// Residual of the last sweep, m/s.
    last: f64,
    /// Velocities at the start of a sweep.
    before: Vec<Body>,
}

impl Anderson {
    /// Creates the method with a memory of at most [`MOST_MEMORY`](crate::scene::MOST_MEMORY) earlier sweeps.
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

    /// Sweeps from the present state and stores the result.
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

    /// Replaces the present state by the best combination of sweep results; returns false if only the last one is stored.
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

/// Weights c of sum one that minimise `c.A c`: `A z = 1`, `c = z / sum z`, by Cholesky. Returns `None` with fewer than two
/// sweeps, if A is not positive definite, or if the sum of z is not positive.
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
