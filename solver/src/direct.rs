//! A direct reference: the contact problem of one small step, solved to rounding with dense matrices.
//!
//! With the relative velocities `u = G v`, the operator `A = G M^-1 G^T + Sigma'` and `w = A lambda + c`, where c holds the
//! velocities without impulses and the biases, a solution is a zero of Alart and Curnier's function
//!
//! ```text
//! y_n = lambda_n - w_n / D_n      Phi_n = lambda_n - max(0, y_n)
//! y_t = lambda_t - w_t / D_t      Phi_t = lambda_t - P_r[y_t]        r = mu max(0, y_n)
//! ```
//!
//! with the exact disc. Phi is piecewise smooth; Newton's method with one of its Jacobians ends after a few steps, once the sets of
//! open, sticking and sliding contacts are right (P. Alart and A. Curnier, *A mixed formulation for frictional contact problems prone
//! to Newton like solution methods*, Computer Methods in Applied Mechanics and Engineering 92, 1991). Far from there it may run in
//! circles: a step counts only if a line search finds that `|D Phi|` falls, else Gauss-Seidel sweeps take over for a
//! while. Where impulses are not determined the Jacobian is singular or nearly so. Directions then come from an operator
//! with a little compliance, as in the proximal-point method (R. T. Rockafellar, SIAM Journal on Control and Optimization 14, 1976);
//! the function whose zero is sought stays what it is.
//!
//! Nothing here is shared with the kernels but the constraint data: it is a witness for all methods.

use crate::Simulation;
use crate::groups::ContactLanes;
use crate::schedule::Team;
use crate::world::World;
use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};

/// Most contacts: matrices are dense, and a step takes time with the third power.
pub const MOST_CONTACTS: usize = 500;

/// Sweeps before the first Newton step, and where one fails.
const SWEEPS: usize = 100;

/// Rounds of Newton steps and sweeps before it gives up.
const ROUNDS: usize = 300;

/// Halvings of a Newton step.
const HALVINGS: usize = 12;

/// Natural-map residual over the largest velocity of the problem at which it is solved.
const TOLERANCE: f64 = 1e-14;

/// Residual, over the same, that is no longer a solution.
const WORST: f64 = 1e-12;

/// Shares of the operator's diagonal that are added to it in Newton's direction, one after the other until one leads down.
const REGULARISATIONS: [f64; 5] = [0.0, 1e-9, 1e-6, 1e-4, 1e-2];

/// Biases below this belong to contacts that must bear nothing, m/s.
const NEVER: f64 = -1e29;

/// Why there is no direct solution.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DirectError {
    /// Matrices would be too large.
    #[error("{contacts} contacts are too many for dense matrices; take a scene with at most {MOST_CONTACTS}")]
    TooLarge {
        /// Contacts of the step.
        contacts: usize,
    },
    /// Neither Newton steps nor sweeps arrive: so it is with some piles of rigid grains with friction, whose solutions are not
    /// isolated.
    #[error("the direct solution stopped at a residual of {residual:e} m/s; there may be none at this friction")]
    NotConverged {
        /// Largest natural-map residual, m/s.
        residual: f64,
    },
}

/// A step's solution to rounding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DirectSolution {
    /// Velocities at the end of the step, by grain id, m/s.
    pub velocities: Vec<[f64; 3]>,
    /// Surface speeds (radius times angular velocity) at the end of the step, by grain id, m/s.
    pub surface_speeds: Vec<[f64; 3]>,
    /// Rates of driven walls at the end of the step, in the order of the scene, m/s or rad/s.
    pub wall_rates: Vec<f64>,
    /// Impulses on the second body or wall of each contact that may bear one, N s.
    pub impulses: Vec<[f64; 3]>,
    /// Certificate: largest natural-map residual `|change of lambda| D` of any contact, m/s.
    pub residual: f64,
    /// Newton steps that it took.
    pub newton_steps: usize,
}

impl Simulation {
    /// Solves the contact problem of the next step directly. The simulation itself stays as it is.
    ///
    /// # Errors
    /// [`DirectError`] if there are more than [`MOST_CONTACTS`] contacts or no solution was found.
    pub fn direct_solution(&self) -> Result<DirectSolution, DirectError> {
        let mut copy = self.clone();
        let team = Team::default();
        copy.pose_problem(&team);
        if copy.layout.contacts > MOST_CONTACTS {
            return Err(DirectError::TooLarge { contacts: copy.layout.contacts });
        }
        let mut problem = Dense::new(&copy);
        let newton_steps = problem.solve();
        let residual = problem.scaled_function(&problem.impulses).amax();
        if residual.is_nan() || residual > WORST * problem.scale {
            return Err(DirectError::NotConverged { residual });
        }
        let bodies = &problem.free + problem.to_bodies * &problem.impulses;
        let grain =
            |place: &u32, offset: usize| std::array::from_fn(|axis| bodies[6 * *place as usize + offset + axis]);
        let places = copy.places_by_id();
        let world = |(index, contact): (usize, &DenseContact)| {
            (contact.frame * Vector3::from_fn(|axis, _| problem.impulses[3 * index + axis])).into()
        };
        Ok(DirectSolution {
            velocities: places.iter().map(|place| grain(place, 0)).collect(),
            surface_speeds: places.iter().map(|place| grain(place, 3)).collect(),
            wall_rates: bodies.iter().skip(6 * places.len()).copied().collect(),
            impulses: problem.contacts.iter().enumerate().map(world).collect(),
            residual,
            newton_steps,
        })
    }
}

/// One contact in its own frame: normal and two tangential directions.
struct DenseContact {
    first: usize,
    /// Absent where the contact is with a wall.
    second: Option<usize>,
    frame: Matrix3<f64>,
    bias: f64,
    regularisation: f64,
    friction: f64,
    impulse: Vector3<f64>,
    wall_velocity: Vector3<f64>,
    /// Number of the drive that moves the wall, and the Jacobian there; absent where none does.
    driven: Option<(usize, Vector3<f64>)>,
}

impl DenseContact {
    fn read(lanes: &ContactLanes, lane: usize, first: u32, second: Option<u32>, wall_velocity: Vector3<f64>) -> Self {
        let normal = Vector3::from(lanes.normal(lane));
        let least = normal.iamin();
        let u = normal.cross(&Vector3::ith(least, 1.0)).normalize();
        let frame = Matrix3::from_columns(&[normal, u, normal.cross(&u)]);
        let impulse = Vector3::from(lanes.tangential_impulse(lane)) + normal * lanes.normal_impulse(lane);
        DenseContact {
            first: first as usize,
            second: second.map(|place| place as usize),
            frame,
            bias: lanes.bias.0[lane],
            regularisation: lanes.regularisation.0[lane],
            friction: lanes.friction(lane),
            impulse: frame.transpose() * impulse,
            wall_velocity,
            driven: None,
        }
    }
}

/// The problem as dense matrices, three rows a contact, six columns a body and one a driven wall.
struct Dense {
    contacts: Vec<DenseContact>,
    /// Velocities and surface speeds without impulses, m/s.
    free: DVector<f64>,
    /// `M^-1 G^T`.
    to_bodies: DMatrix<f64>,
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
    fn new(simulation: &Simulation) -> Dense {
        let world = &simulation.world;
        let mut contacts = contacts_of(simulation);
        contacts.retain(|contact| contact.bias > NEVER);
        let (rows, columns) = (3 * contacts.len(), 6 * world.grains() + world.drives.len());
        // G: relative velocity v_b - v_a + n x (s_a + s_b), turned into the contact's frame.
        let mut gradient = DMatrix::zeros(rows, columns);
        let mut wall = DVector::zeros(rows);
        let mut impulses = DVector::zeros(rows);
        for (index, contact) in contacts.iter().enumerate() {
            let turn = contact.frame.transpose();
            let spin = turn * contact.frame.column(0).into_owned().cross_matrix();
            gradient.view_mut((3 * index, 6 * contact.first), (3, 3)).copy_from(&-turn);
            gradient.view_mut((3 * index, 6 * contact.first + 3), (3, 3)).copy_from(&spin);
            if let Some(second) = contact.second {
                gradient.view_mut((3 * index, 6 * second), (3, 3)).copy_from(&turn);
                gradient.view_mut((3 * index, 6 * second + 3), (3, 3)).copy_from(&spin);
            }
            if let Some((drive, jacobian)) = contact.driven {
                gradient.view_mut((3 * index, 6 * world.grains() + drive), (3, 1)).copy_from(&(turn * jacobian));
            }
            wall.rows_mut(3 * index, 3).copy_from(&(turn * contact.wall_velocity));
            impulses.rows_mut(3 * index, 3).copy_from(&contact.impulse);
        }
        let (present, inverse_masses) = bodies_of(world);
        let mut to_bodies = gradient.transpose();
        for (mut row, inverse_mass) in to_bodies.row_iter_mut().zip(&inverse_masses) {
            row *= *inverse_mass;
        }
        let mut operator = &gradient * &to_bodies;
        let free = present - &to_bodies * &impulses;
        let mut offset = &gradient * &free + wall;
        let mut diagonal = DVector::zeros(rows);
        for (index, contact) in contacts.iter().enumerate() {
            operator[(3 * index, 3 * index)] += contact.regularisation;
            offset[3 * index] -= contact.bias;
            diagonal[3 * index] = operator[(3 * index, 3 * index)];
            // Sliding opposes the velocity only if both directions are scaled alike: a driven wall gives more way in one.
            let [u, v] = [1, 2].map(|axis| operator[(3 * index + axis, 3 * index + axis)]);
            diagonal.rows_mut(3 * index + 1, 2).fill(u.max(v));
        }
        let scale = if rows == 0 { 1.0 } else { offset.amax().max(free.amax()).max(f64::MIN_POSITIVE) };
        Dense { contacts, free, to_bodies, operator, offset, diagonal, impulses, scale }
    }

    /// Newton steps, with sweeps where they fail; returns the number of steps. Leaves impulses inside their cones.
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
        // At the zero this changes nothing but rounding.
        let projected = self.projected(&self.impulses);
        let worse = self.scaled_function(&projected).amax() > 2.0 * self.scaled_function(&self.impulses).amax();
        if !worse {
            self.impulses = projected;
        }
        steps
    }

    /// The point of a line search along Newton's direction where `|D Phi|` has fallen; absent where there is none.
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

    /// `lambda - w / D`, all of it.
    fn target(&self, impulses: &DVector<f64>) -> DVector<f64> {
        impulses - (&self.operator * impulses + &self.offset).component_div(&self.diagonal)
    }

    /// Projects targets: normal parts onto repulsion, tangential parts onto the disc at that normal part.
    fn projected(&self, target: &DVector<f64>) -> DVector<f64> {
        let mut projected = target.clone();
        for (index, contact) in self.contacts.iter().enumerate() {
            let row = 3 * index;
            let [normal, u, v] = project([target[row], target[row + 1], target[row + 2]], contact.friction);
            (projected[row], projected[row + 1], projected[row + 2]) = (normal, u, v);
        }
        projected
    }

    /// `D Phi`, m/s: the natural map that methods report too.
    fn scaled_function(&self, impulses: &DVector<f64>) -> DVector<f64> {
        (impulses - self.projected(&self.target(impulses))).component_mul(&self.diagonal)
    }

    /// A Jacobian of `D Phi` by `D lambda`, of an operator that has a share of its diagonal added to it.
    fn jacobian(&self, regularisation: f64) -> DMatrix<f64> {
        let size = self.impulses.len();
        let target = self.target(&self.impulses);
        // Of y by lambda: I - A / D.
        let mut by_impulse = -&self.operator;
        for row in 0..size {
            by_impulse.row_mut(row).unscale_mut(self.diagonal[row]);
            by_impulse[(row, row)] += 1.0 - regularisation;
        }
        let mut jacobian = DMatrix::identity(size, size);
        for (index, contact) in self.contacts.iter().enumerate() {
            let row = 3 * index;
            let (normal, tangential) = (target[row], Vector2::new(target[row + 1], target[row + 2]));
            if normal <= 0.0 {
                continue;
            }
            let own = jacobian.row(row) - by_impulse.row(row);
            jacobian.row_mut(row).copy_from(&own);
            let (length, radius) = (tangential.norm(), contact.friction * normal);
            for axis in 0..2 {
                let mut change = jacobian.row(row + 1 + axis).into_owned();
                if length <= radius {
                    change -= by_impulse.row(row + 1 + axis);
                } else {
                    // P = r y/|y|: it turns with y and grows with r.
                    let along = tangential / length;
                    for other in 0..2 {
                        let turns = f64::from(u8::from(axis == other)) - along[axis] * along[other];
                        change -= by_impulse.row(row + 1 + other) * (radius / length * turns);
                    }
                    change -= by_impulse.row(row) * (contact.friction * along[axis]);
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

    /// Gauss-Seidel over contacts.
    fn sweep(&mut self, times: usize) {
        for _ in 0..times {
            for (index, contact) in self.contacts.iter().enumerate() {
                let row = 3 * index;
                let target = [0, 1, 2].map(|axis| {
                    let velocity = self.operator.column(row + axis).dot(&self.impulses) + self.offset[row + axis];
                    self.impulses[row + axis] - velocity / self.diagonal[row + axis]
                });
                for (axis, value) in project(target, contact.friction).into_iter().enumerate() {
                    self.impulses[row + axis] = value;
                }
            }
        }
    }
}

/// Coulomb's law: repulsion, then the disc at that normal impulse.
fn project([normal, u, v]: [f64; 3], friction: f64) -> [f64; 3] {
    let normal = normal.max(0.0);
    let (length, radius) = (u.hypot(v), friction * normal);
    let share = if length <= radius { 1.0 } else { radius / length };
    [normal, u * share, v * share]
}

/// The contacts that are laid out.
fn contacts_of(simulation: &Simulation) -> Vec<DenseContact> {
    let mut contacts = Vec::with_capacity(simulation.layout.contacts);
    // They are listed in the order in which they come here.
    let mut driven = simulation.layout.driven.iter();
    for (_, task) in simulation.layout.tasks() {
        for (group, sources) in task.pairs.iter().zip(&task.pair_sources) {
            for (lane, _) in sources.occupied() {
                let second = Some(group.second[lane]);
                contacts.push(DenseContact::read(&group.contacts, lane, group.first[lane], second, Vector3::zeros()));
            }
        }
        for (number, (group, sources)) in task.walls.iter().zip(&task.wall_sources).enumerate() {
            for (lane, _) in sources.occupied() {
                let velocity = Vector3::from_fn(|axis, _| group.wall_velocity[axis].0[lane]);
                let mut contact = DenseContact::read(&group.contacts, lane, group.body[lane], None, velocity);
                if number >= task.prescribed_walls() {
                    contact.wall_velocity = Vector3::zeros();
                    contact.driven = driven.next().map(|one| (one.drive as usize, one.jacobian.into()));
                }
                contacts.push(contact);
            }
        }
    }
    contacts
}

/// Velocities and surface speeds of the grains, then rates of driven walls, and the inverse masses that go with them: 2.5/m for a
/// solid sphere's surface speed.
fn bodies_of(world: &World) -> (DVector<f64>, Vec<f64>) {
    let grains = &world.bodies[..world.grains()];
    let present = grains.iter().flat_map(|body| body.velocity.into_iter().chain(body.surface_speed));
    let masses = grains.iter().flat_map(|body| [1.0, 1.0, 1.0, 2.5, 2.5, 2.5].map(|factor| factor * body.inverse_mass));
    let drives = &world.drives;
    let present = present.chain(drives.iter().map(|drive| drive.rate));
    let masses = masses.chain(drives.iter().map(|drive| drive.inverse_inertia));
    (DVector::from_iterator(6 * grains.len() + drives.len(), present), masses.collect())
}
