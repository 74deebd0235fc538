//! Residuals of a sweep: |delta lambda| S, in m/s, for the normal and two tangential directions, and for the relative rotation of
//! two surfaces.

/// Normal, two tangential, and turning.
const DIRECTIONS: usize = 4;

use crate::lanes::{Eight, LANES, Lanes, Number, SingleLanes, Sixteen, dot};
use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// Root mean square and maximum of a residual over all contacts, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Root mean square, m/s.
    pub rms: f64,
    /// Maximum, m/s.
    pub max: f64,
}

/// Residuals of one sweep, m/s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residuals {
    /// Normal direction.
    pub normal: Residual,
    /// First tangential direction.
    pub tangential_u: Residual,
    /// Second tangential direction.
    pub tangential_v: Residual,
    /// Turning: angular velocity times the smaller radius; zero without resistance to turning.
    #[serde(default)]
    pub turning: Residual,
}

impl Residuals {
    /// Root mean square over all directions, m/s.
    pub fn rms(&self) -> f64 {
        let square = |residual: &Residual| residual.rms * residual.rms;
        (square(&self.normal) + square(&self.tangential_u) + square(&self.tangential_v) + square(&self.turning)).sqrt()
    }
}

/// Detail of the residuals of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResidualLevel {
    /// No residuals.
    Off,
    /// Root mean squares, normal and tangential; the first tangential direction holds the tangential total. Nearly free.
    Total,
    /// Root mean squares and maxima in every direction, at more than half the cost of a sweep.
    Directions,
}

/// Residual level known at compile time.
pub(crate) trait MeasuredLevel {
    /// True if the level measures residuals.
    const ANY: bool;
    /// True if the level separates directions and includes maxima.
    const DIRECTIONS: bool;
}

/// Compile-time residual level.
pub(crate) struct Compiled<const ANY: bool, const DIRECTIONS: bool>;
/// [`ResidualLevel::Off`].
pub(crate) type Off = Compiled<false, false>;
/// [`ResidualLevel::Total`].
pub(crate) type Total = Compiled<true, false>;
/// [`ResidualLevel::Directions`].
pub(crate) type Directions = Compiled<true, true>;

impl<const ANY: bool, const DIRECTIONS: bool> MeasuredLevel for Compiled<ANY, DIRECTIONS> {
    const ANY: bool = ANY;
    const DIRECTIONS: bool = DIRECTIONS;
}

/// Evaluates an expression for the compile-time level of a value.
macro_rules! with_level {
    ($level:expr, $compiled:ident => $body:expr) => {
        $crate::sweep::residual::with_level!($level, $compiled => $body; Off, Total, Directions)
    };
    ($level:expr, $compiled:ident => $body:expr; $($each:ident),*) => {{
        use $crate::sweep::residual::{self, ResidualLevel};
        match $level { $(ResidualLevel::$each => { type $compiled = residual::$each; $body })* }
    }};
}
pub(super) use with_level;

/// Sums over lane groups during relaxation, separate for each lane, so that their order is fixed.
#[derive(Clone, Copy)]
pub(crate) struct LaneResidual<N> {
    squares: [N; DIRECTIONS],
    largest: [N; DIRECTIONS],
}

/// Residual sums of a task in memory.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct TaskResidual {
    squares: [Eight; DIRECTIONS],
    largest: [Eight; DIRECTIONS],
}

impl<N: Number> LaneResidual<N> {
    #[inline(always)]
    fn add(&mut self, direction: usize, value: N) {
        self.squares[direction] = self.squares[direction] + value * value;
        self.largest[direction] = self.largest[direction].larger(value.abs());
    }

    /// Adds a square to a sum, without a maximum.
    #[inline(always)]
    fn add_square(&mut self, direction: usize, square: N) {
        self.squares[direction] = self.squares[direction] + square;
    }

    /// Adds the normal residuals of a group.
    #[inline(always)]
    pub fn add_normal<G: MeasuredLevel>(&mut self, value: N) {
        if G::DIRECTIONS {
            self.add(0, value);
        } else {
            self.add_square(0, value * value);
        }
    }

    /// Splits the tangential residual vectors of a group along two directions perpendicular to the normal, if the level separates
    /// directions.
    ///
    /// The basis is free of branches and continuous except at one seam (Duff et al., J. Comput. Graph. Tech. 6(1), 2017).
    #[inline(always)]
    pub fn add_tangential<G: MeasuredLevel>(&mut self, normal: [N; 3], value: [N; 3]) {
        if !G::DIRECTIONS {
            return self.add_square(1, dot(value, value));
        }
        let one = N::splat(1.0);
        let sign = N::select(N::zero().at_most(normal[2]), one, -one);
        let a = -(one / (sign + normal[2]));
        let b = normal[0] * normal[1] * a;
        let u = [one + sign * normal[0] * normal[0] * a, sign * b, -(sign * normal[0])];
        let v = [b, sign + normal[1] * normal[1] * a, -normal[1]];
        self.add(1, dot(u, value));
        self.add(2, dot(v, value));
    }

    /// Adds the surface velocities of the remaining relative rotation in a group.
    #[inline(always)]
    pub fn add_turning<G: MeasuredLevel>(&mut self, value: [N; 3]) {
        let square = dot(value, value);
        if G::DIRECTIONS {
            self.add(3, square.sqrt());
        } else {
            self.add_square(3, square);
        }
    }

    /// Returns empty sums.
    #[inline(always)]
    pub fn zero() -> Self {
        Self { squares: [N::zero(); DIRECTIONS], largest: [N::zero(); DIRECTIONS] }
    }
}

impl<L: Lanes> LaneResidual<L> {
    /// Returns the sums so far.
    #[inline(always)]
    pub fn read(from: &TaskResidual) -> Self {
        Self { squares: from.squares.each_ref().map(L::load), largest: from.largest.each_ref().map(L::load) }
    }

    /// Stores the sums.
    #[inline(always)]
    pub fn write(self, to: &mut TaskResidual) {
        for direction in 0..DIRECTIONS {
            self.squares[direction].store(&mut to.squares[direction]);
            self.largest[direction].store(&mut to.largest[direction]);
        }
    }
}

impl<S: SingleLanes> LaneResidual<S> {
    /// Adds the sums of sixteen lanes, two by two.
    #[inline(always)]
    pub fn add_to(self, to: &mut TaskResidual) {
        for direction in 0..DIRECTIONS {
            let [mut squares, mut largest] = [Sixteen::default(); 2];
            self.squares[direction].store(&mut squares);
            self.largest[direction].store(&mut largest);
            for lane in 0..LANES {
                let halves = |sixteen: &Sixteen| [lane, LANES + lane].map(|lane| f64::from(sixteen.0[lane]));
                let ([low, high], [a, b]) = (halves(&squares), halves(&largest));
                to.squares[direction].0[lane] += low + high;
                let all = &mut to.largest[direction].0[lane];
                *all = all.larger(a.larger(b));
            }
        }
    }
}

impl TaskResidual {
    /// Adds the residuals of one lane.
    pub(super) fn add_lane(&mut self, lane: usize, own: LaneResidual<f64>) {
        for direction in 0..DIRECTIONS {
            self.squares[direction].0[lane] += own.squares[direction];
            let largest = &mut self.largest[direction].0[lane];
            *largest = largest.larger(own.largest[direction]);
        }
    }

    /// Adds the sums of another task; the caller must follow the order of tasks.
    pub fn merge(&mut self, other: &TaskResidual) {
        for direction in 0..DIRECTIONS {
            for lane in 0..LANES {
                self.squares[direction].0[lane] += other.squares[direction].0[lane];
                let largest = &mut self.largest[direction].0[lane];
                *largest = largest.larger(other.largest[direction].0[lane]);
            }
        }
    }

    /// Returns the residuals over `contacts` contacts.
    pub fn finish(&self, contacts: usize) -> Residuals {
        // Fixed order of summation.
        let sum = |[a, b, c, d, e, f, g, h]: [f64; 8]| ((a + b) + (c + d)) + ((e + f) + (g + h));
        let residual = |direction: usize| Residual {
            rms: (sum(self.squares[direction].0) / contacts.max(1) as f64).sqrt(),
            max: self.largest[direction].0.iter().copied().fold(0.0, f64::max),
        };
        Residuals { normal: residual(0), tangential_u: residual(1), tangential_v: residual(2), turning: residual(3) }
    }
}
