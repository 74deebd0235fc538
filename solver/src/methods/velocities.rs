//! Linear algebra over the velocities of all bodies, one cache line per body.

use crate::lanes::{Available, Eight, Kernel, LANES, Lanes};
use crate::schedule::{Each, Phase, Team};
use crate::world::{Body, INERTIA, by_chunk, chunk, chunks};

/// Maximum number of states in a combination or a set of products.
pub(crate) const MOST: usize = crate::scene::MOST_MEMORY + 1;

/// Coefficients of new states (rows) by old states.
pub(crate) type Coefficients = [[f64; 3]; 3];

/// Energy weights: `m v^2 + INERTIA m s^2` is twice the kinetic energy of a solid sphere with scaled spin s.
const KINETIC: Eight = Eight([1.0, 1.0, 1.0, 0.0, INERTIA, INERTIA, INERTIA, 0.0]);

/// Returns a body as eight numbers: velocity, inverse mass, scaled spin, inverse radius.
#[inline(always)]
fn numbers(body: &Body) -> &Eight {
    bytemuck::must_cast_ref(body)
}

/// Writes a body's velocities; its mass and radius stay unchanged.
#[inline(always)]
fn write<L: Lanes>(value: L, body: &mut Body) {
    let (inverse_mass, inverse_radius) = (body.inverse_mass, body.inverse_radius);
    value.store(bytemuck::must_cast_mut(body));
    (body.inverse_mass, body.inverse_radius) = (inverse_mass, inverse_radius);
}

/// Computes `to = sum of coefficients[i] from[i]`, velocities only. No allocation; `from` has at most [`MOST`] states.
pub(crate) fn combine(to: &mut [Body], coefficients: &[f64], from: &[&[Body]], set: Available, team: &Team) {
    let count = to.len();
    team.each_with(Phase::Sweep, chunks(count), by_chunk(to), |number, to| {
        let places = chunk(number, count);
        let mut parts: [&[Body]; MOST] = [&[]; MOST];
        for (part, from) in parts.iter_mut().zip(from) {
            *part = &from[places.clone()];
        }
        set.run(Combine { to, coefficients, from: &parts[..from.len()] });
    });
}

struct Combine<'a> {
    to: &'a mut [Body],
    coefficients: &'a [f64],
    from: &'a [&'a [Body]],
}

impl Kernel for Combine<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (place, to) in self.to.iter_mut().enumerate() {
            let mut sum = L::zero();
            for (coefficient, from) in self.coefficients.iter().zip(self.from) {
                sum = sum + L::splat(*coefficient) * L::load(numbers(&from[place]));
            }
            write(sum, to);
        }
    }
}

/// Replaces three states by combinations of themselves.
pub(crate) fn transform(states: [&mut [Body]; 3], coefficients: &Coefficients, set: Available, team: &Team) {
    let count = states[0].len();
    team.each_with(Phase::Sweep, chunks(count), states.map(by_chunk), |_, states| {
        set.run(Transform { states, coefficients });
    });
}

struct Transform<'a> {
    states: [&'a mut [Body]; 3],
    coefficients: &'a Coefficients,
}

impl Kernel for Transform<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let [first, second, third] = self.states;
        let [to_first, to_second, to_third] = self.coefficients;
        for ((first, second), third) in first.iter_mut().zip(second).zip(third) {
            let old = [L::load(numbers(first)), L::load(numbers(second)), L::load(numbers(third))];
            write(combined(to_first, old), first);
            write(combined(to_second, old), second);
            write(combined(to_third, old), third);
        }
    }
}

/// Computes one row of a transform.
#[inline(always)]
pub(crate) fn combined<L: Lanes>(row: &[f64; 3], old: [L; 3]) -> L {
    L::splat(row[0]) * old[0] + L::splat(row[1]) * old[1] + L::splat(row[2]) * old[2]
}

/// Computes `difference = a - b`, and returns twice its kinetic energy, J; sums follow the order of chunks.
pub(crate) fn difference(
    difference: &mut [Body],
    [a, b]: [&[Body]; 2],
    sums: &mut Vec<[Eight; MOST]>,
    set: Available,
    team: &Team,
) -> f64 {
    combine(difference, &[1.0, -1.0], &[a, b], set, team);
    products(difference, &[difference], sums, set, team)[0]
}

/// Returns twice the kinetic energies `m a.b` of one difference of velocities with several, J.
pub(crate) fn products(
    one: &[Body],
    others: &[&[Body]],
    sums: &mut Vec<[Eight; MOST]>,
    set: Available,
    team: &Team,
) -> [f64; MOST] {
    let count = one.len();
    sums.clear();
    sums.resize(chunks(count), [Eight::default(); MOST]);
    team.each_with(Phase::Sweep, chunks(count), Each::of(sums), |number, sums| {
        let places = chunk(number, count);
        for (sum, other) in sums.iter_mut().zip(others) {
            set.run(Product { one: &one[places.clone()], other: &other[places.clone()], sum });
        }
    });
    let mut totals = [0.0; MOST];
    for (index, total) in totals.iter_mut().enumerate() {
        let mut lanes = [0.0; LANES];
        for sum in sums.iter() {
            for (lane, own) in lanes.iter_mut().zip(sum[index].0) {
                *lane += own;
            }
        }
        *total = sum_of(lanes);
    }
    totals
}

/// Returns the sum over lanes in a fixed order.
pub(crate) fn sum_of([a, b, c, d, e, f, g, h]: [f64; LANES]) -> f64 {
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}

struct Product<'a> {
    one: &'a [Body],
    other: &'a [Body],
    sum: &'a mut Eight,
}

impl Kernel for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let weight = L::load(&KINETIC);
        let mut sum = L::zero();
        for (one, other) in self.one.iter().zip(self.other) {
            let mass = weight * L::splat(1.0 / one.inverse_mass);
            sum = sum + mass * L::load(numbers(one)) * L::load(numbers(other));
        }
        sum.store(self.sum);
    }
}
