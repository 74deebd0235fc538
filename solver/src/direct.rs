//! Direct reference solution: the contact problem of one small step, solved to rounding with dense matrices.
//!
//! Let `u = G v` be the relative velocities, `A = G M^-1 G^T + Sigma'` the operator, and `w = A lambda + c`. The vector c contains the
//! velocities without impulses and the biases (the [`LocalProblem`]). A solution is a zero of Alart and Curnier's function
//!
//! ```text
//! y_n = lambda_n - w_n / D_n      Phi_n = lambda_n - max(0, y_n)
//! y_t = lambda_t - w_t / D_t      Phi_t = lambda_t - P_r[y_t]        r = mu max(0, y_n)
//! ```
//!
//! with the exact disc. Phi is piecewise smooth. Newton's method with one of its Jacobians converges in a few steps,
//! once the sets of open, sticking and sliding contacts are correct (P. Alart and A. Curnier, *A mixed formulation for
//! frictional contact problems prone to Newton like solution methods*, Computer Methods in Applied Mechanics and
//! Engineering 92, 1991). Far from the solution, the method may cycle: a step is accepted only if a line search reduces
//! `|D Phi|`, otherwise Gauss-Seidel sweeps follow. For indeterminate impulses, the Jacobian is singular or nearly
//! singular. Directions then use an operator with a little compliance, as in the proximal-point method (R. T.
//! Rockafellar, SIAM Journal on Control and Optimization 14, 1976); the function Phi is unchanged.
//!
//! This module shares only the [problem](crate::problem) as plain data with the kernels: an independent reference for all methods.

use crate::Simulation;
use crate::effects::drive::Drive;
use crate::problem::LocalProblem;
use nalgebra::{DMatrix, DVector, Vector2, Vector3};

/// Largest number of contacts: matrices are dense, and the time of a step grows with the third power.
pub const MOST_CONTACTS: usize = 500;

/// Sweeps before the first Newton step, and after a failed one.
const SWEEPS: usize = 100;

/// Largest number of rounds of Newton steps and sweeps.
const ROUNDS: usize = 300;

/// Largest number of halvings of a Newton step.
const HALVINGS: usize = 12;

/// Natural-map residual of a solution, over the largest velocity of the problem.
const TOLERANCE: f64 = 1e-14;

/// Largest accepted residual, over the largest velocity of the problem.
const WORST: f64 = 1e-12;

/// Fractions of the operator's diagonal, added in Newton's direction one after another until a direction of descent is found.
const REGULARISATIONS: [f64; 5] = [0.0, 1e-9, 1e-6, 1e-4, 1e-2];

/// Reason for the lack of a direct solution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DirectError {
    /// The matrices would be too large.
    #[error("{contacts} contacts are too many for dense matrices; take a scene with at most {MOST_CONTACTS}")]
    TooLarge {
        /// Number of contacts of the step.
        contacts: usize,
    },
    /// The direct solution has no angular impulses.
    #[error("contacts resist rolling or twisting, which the direct solution leaves out; take a scene without")]
    Torques,
    /// Neither Newton steps nor sweeps converge, as for some piles of rigid frictional grains with solutions that are
    /// not isolated.
    #[error("the direct solution stopped at a residual of {residual:e} m/s; there may be none at this friction")]
    NotConverged {
        /// Largest natural-map residual, m/s.
        residual: f64,
    },
}

/// Solution of a step to rounding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirectSolution {
    /// Velocities at the end of the step, by grain id, m/s.
    pub velocities: Vec<[f64; 3]>,
    /// Surface speeds (radius times angular velocity) at the end of the step, by grain id, m/s.
    pub scaled_spins: Vec<[f64; 3]>,
    /// Rates of dynamic walls at the end of the step, in the order of the scene, m/s or rad/s.
    pub wall_rates: Vec<f64>,
    /// Impulses on the second body or wall of each contact that may be active, N s.
    pub impulses: Vec<[f64; 3]>,
    /// Certificate: largest natural-map residual `|change of lambda| D` of any contact, m/s.
    pub residual: f64,
    /// Number of Newton steps.
    pub newton_steps: usize,
}

impl Simulation {
    /// Solves the contact problem of the next step directly. The simulation remains unchanged.
    ///
    /// # Errors
    /// [`DirectError`] if there are more than [`MOST_CONTACTS`] contacts or no solution was found.
    pub fn direct_solution(&self) -> Result<DirectSolution, DirectError> {
        let problem = self.contact_problem();
        if problem.resists_turning() {
            return Err(DirectError::Torques);
        }
        let local = problem.local();
        let direct = local.direct_solution()?;
        let impulses = problem.impulses_of(&local, &direct.impulses);
        let state = problem.state_of(&impulses);
        let (grains, drives) = (problem.grains, &self.world.drives);
        let scaled_spin =
            |(place, spin): (u32, &Vector3<f64>)| (spin * self.world.spheres[place as usize].radius).into();
        let moving = state.velocities[grains..].iter().zip(&state.spins[grains..]);
        let rate =
            |(drive, (velocity, spin)): (&Drive, (&Vector3<f64>, &Vector3<f64>))| (velocity + spin).dot(&drive.axis());
        let vector = |&number: &usize| impulses[number].vector(&problem.contacts[number].normal).into();
        Ok(DirectSolution {
            velocities: state.velocities[..grains].iter().map(|&velocity| velocity.into()).collect(),
            scaled_spins: self.places_by_id().into_iter().zip(&state.spins).map(scaled_spin).collect(),
            wall_rates: drives.iter().zip(moving).map(rate).collect(),
            impulses: local.contacts.iter().map(vector).collect(),
            residual: direct.residual,
            newton_steps: direct.newton_steps,
        })
    }
}

/// Solution of a local problem to rounding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LocalSolution {
    /// Impulses in the frames of the contacts, N s.
    pub impulses: Vec<Vector3<f64>>,
    /// Certificate: largest natural-map residual `|change of lambda| D` of any contact, m/s.
    pub residual: f64,
    /// Number of Newton steps.
    pub newton_steps: usize,
}

impl LocalProblem {
    /// Solves the problem directly.
    ///
    /// # Errors
    /// [`DirectError`] if there are more than [`MOST_CONTACTS`] contacts or no solution was found.
    pub fn direct_solution(&self) -> Result<LocalSolution, DirectError> {
        if self.offset.len() > MOST_CONTACTS {
            return Err(DirectError::TooLarge { contacts: self.offset.len() });
        }
        let mut dense = Dense::new(self);
        let newton_steps = dense.solve();
        let residual = if dense.impulses.is_empty() { 0.0 } else { dense.scaled_function(&dense.impulses).amax() };
        if residual.is_nan() || residual > WORST * dense.scale {
            return Err(DirectError::NotConverged { residual });
        }
        let vector = |row: usize| Vector3::from_fn(|axis, _| dense.impulses[3 * row + axis]);
        Ok(LocalSolution { impulses: (0..self.offset.len()).map(vector).collect(), residual, newton_steps })
    }
}

/// Problem as dense matrices, three rows per contact.
struct Dense {
    /// Coefficient of friction of each contact.
    friction: Vec<f64>,
    /// A, 1/kg.
    operator: DMatrix<f64>,
    /// c, m/s.
    offset: DVector<f64>,
    /// D, 1/kg.
    diagonal: DVector<f64>,
    /// lambda, N s.
    impulses: DVector<f64>,
    /// Largest velocity of the problem, m/s.
    scale: f64,
}

impl Dense {
    fn new(local: &LocalProblem) -> Dense {
        let rows = 3 * local.offset.len();
        let mut operator = DMatrix::zeros(rows, rows);
        for block in &local.blocks {
            operator.view_mut((3 * block.row, 3 * block.column), (3, 3)).copy_from(&block.values);
        }
        let flat = |vectors: &[Vector3<f64>]| DVector::from_iterator(rows, vectors.iter().flatten().copied());
        let (offset, mut diagonal) = (flat(&local.offset), operator.diagonal());
        for row in (0..rows).step_by(3) {
            // Sliding opposes the velocity only if both directions have the same scale: a dynamic wall is more mobile in one direction.
            let larger = diagonal[row + 1].max(diagonal[row + 2]);
            diagonal.rows_mut(row + 1, 2).fill(larger);
        }
        let scale = if rows == 0 { 1.0 } else { offset.amax().max(f64::MIN_POSITIVE) };
        Dense { friction: local.friction.clone(), operator, offset, diagonal, impulses: flat(&local.impulses), scale }
    }

    /// Runs Newton steps, with sweeps after failed ones; returns the number of steps. The resulting impulses are inside their cones.
    fn solve(&mut self) -> usize {
        let mut steps = 0;
        self.sweep(SWEEPS);
        for _ in 0..ROUNDS {
            let residual = self.scaled_function(&self.impulses);
            if residual.amax() <= TOLERANCE * self.scale {
                break;
            }
            match self.newton_step(&residual) {
                Some(better) => {
                    self.impulses = better;
                    steps += 1;
                }
                None => self.sweep(SWEEPS),
            }
        }
        // At the zero of Phi, the projection changes only rounding.
        let projected = self.projected(&self.impulses);
        let worse = self.scaled_function(&projected).amax() > 2.0 * self.scaled_function(&self.impulses).amax();
        if !worse {
            self.impulses = projected;
        }
        steps
    }

    /// Returns the point of a line search along Newton's direction with a smaller `|D Phi|`, if any.
    fn newton_step(&self, residual: &DVector<f64>) -> Option<DVector<f64>> {
        let norm = residual.norm();
        for regularisation in REGULARISATIONS {
            let Some(scaled) = self.jacobian(regularisation).lu().solve(&-residual) else { continue };
            let direction = scaled.component_div(&self.diagonal);
            let mut share = 1.0;
            for _ in 0..HALVINGS {
                let trial = &self.impulses + &direction * share;
                if self.scaled_function(&trial).norm() < (1.0 - 1e-4 * share) * norm {
                    return Some(trial);
                }
                share *= 0.5;
            }
        }
        None
    }

    /// Returns the complete target `lambda - w / D`.
    fn target(&self, impulses: &DVector<f64>) -> DVector<f64> {
        impulses - (&self.operator * impulses + &self.offset).component_div(&self.diagonal)
    }

    /// Projects targets: normal parts onto repulsion, tangential parts onto the disc at that normal part.
    fn projected(&self, target: &DVector<f64>) -> DVector<f64> {
        let mut projected = target.clone();
        for (index, &friction) in self.friction.iter().enumerate() {
            let row = 3 * index;
            let [normal, u, v] = project([target[row], target[row + 1], target[row + 2]], friction);
            (projected[row], projected[row + 1], projected[row + 2]) = (normal, u, v);
        }
        projected
    }

    /// Returns `D Phi`, m/s: the natural map that methods also report.
    fn scaled_function(&self, impulses: &DVector<f64>) -> DVector<f64> {
        (impulses - self.projected(&self.target(impulses))).component_mul(&self.diagonal)
    }

    /// Returns a Jacobian of `D Phi` by `D lambda`, for an operator with a fraction of its diagonal added.
    fn jacobian(&self, regularisation: f64) -> DMatrix<f64> {
        let size = self.impulses.len();
        let target = self.target(&self.impulses);
        // Derivative of y by lambda: I - A / D.
        let mut by_impulse = -&self.operator;
        for row in 0..size {
            by_impulse.row_mut(row).unscale_mut(self.diagonal[row]);
            by_impulse[(row, row)] += 1.0 - regularisation;
        }
        let mut jacobian = DMatrix::identity(size, size);
        for (index, &friction) in self.friction.iter().enumerate() {
            let row = 3 * index;
            let (normal, tangential) = (target[row], Vector2::new(target[row + 1], target[row + 2]));
            if normal <= 0.0 {
                continue;
            }
            let own = jacobian.row(row) - by_impulse.row(row);
            jacobian.row_mut(row).copy_from(&own);
            let (length, radius) = (tangential.norm(), friction * normal);
            for axis in 0..2 {
                let mut change = jacobian.row(row + 1 + axis).into_owned();
                if length <= radius {
                    change -= by_impulse.row(row + 1 + axis);
                } else {
                    // P = r y/|y|: its direction follows y, and its magnitude follows r.
                    let along = tangential / length;
                    for other in 0..2 {
                        let turns = f64::from(u8::from(axis == other)) - along[axis] * along[other];
                        change -= by_impulse.row(row + 1 + other) * (radius / length * turns);
                    }
                    change -= by_impulse.row(row) * (friction * along[axis]);
                }
                jacobian.row_mut(row + 1 + axis).copy_from(&change);
            }
        }
        for row in 0..size {
            for column in 0..size {
                jacobian[(row, column)] *= self.diagonal[row] / self.diagonal[column];
            }
        }
        jacobian
    }

    /// Runs Gauss-Seidel sweeps over the contacts.
    fn sweep(&mut self, times: usize) {
        for _ in 0..times {
            for (index, &friction) in self.friction.iter().enumerate() {
                let row = 3 * index;
                let target = [0, 1, 2].map(|axis| {
                    let velocity = self.operator.column(row + axis).dot(&self.impulses) + self.offset[row + axis];
                    self.impulses[row + axis] - velocity / self.diagonal[row + axis]
                });
                for (axis, value) in project(target, friction).into_iter().enumerate() {
                    self.impulses[row + axis] = value;
                }
            }
        }
    }
}

/// Projects by Coulomb's law: repulsion, then the disc for the resulting normal impulse.
fn project([normal, u, v]: [f64; 3], friction: f64) -> [f64; 3] {
    let normal = normal.max(0.0);
    let (length, radius) = (u.hypot(v), friction * normal);
    let share = if length <= radius { 1.0 } else { radius / length };
    [normal, u * share, v * share]
}
