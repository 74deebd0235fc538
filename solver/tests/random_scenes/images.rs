//! Images of a scene - its grains in another order, its mirror image, itself turned - that must move as it does.
//!
//! Step by step: from every state that a run comes through, the state and its image take one step each. Compared over several
//! steps, two runs part for reasons that are no error: rounding decides whether a contact that was stopped at touch overlaps in
//! the next step, and the law of contacts jumps there by a fifth of the velocity at which it was stopped; and grains that collide
//! magnify what parts them. From one state all that differs is the order in which contacts are relaxed.
//!
//! The two velocities then differ by no more than the two solves miss their laws, where the laws leave one solution only
//! ([`uniqueness`](super::uniqueness)). Elsewhere - Coulomb's law with rigid contacts may have several - each of the two must
//! still obey the laws as far as its solve says.

use super::contacts::{INERTIA, Laws, Stepped, Touch, farthest, step};
use super::scene::{Drawn, Solves};
use super::uniqueness::{factor, miss};
use makadam::snapshot::{Contact, Partner, Snapshot};
use nalgebra::Vector3;
use proptest::prelude::*;

type Vector = Vector3<f64>;

/// Steps that a run takes, and how many of them lie between two that are compared.
const STEPS: usize = 200;
const STRIDE: usize = 4;

/// Velocities known to this share of the fastest are well known: solves that miss their laws by rounding, some 1e-12 of the
/// velocities, leave these uncertain by its square root or some more.
const SHARP: f64 = 1e-5;

/// A map of scenes.
pub struct Image {
    pub name: &'static str,
    reversed: bool,
    polar: fn(Vector) -> Vector,
    axial: fn(Vector) -> Vector,
    /// Returns the inverse image.
    polar_back: fn(Vector) -> Vector,
    axial_back: fn(Vector) -> Vector,
}

fn same(v: Vector) -> Vector {
    v
}

fn mirrored(v: Vector) -> Vector {
    Vector::new(-v.x, v.y, v.z)
}

/// An axial vector keeps its component across the mirror, and its others turn round.
fn mirrored_axis(v: Vector) -> Vector {
    Vector::new(v.x, -v.y, -v.z)
}

fn turned(v: Vector) -> Vector {
    Vector::new(-v.y, v.x, v.z)
}

fn turned_back(v: Vector) -> Vector {
    Vector::new(v.y, -v.x, v.z)
}

impl Image {
    /// The last grain first.
    pub const REVERSED: Image =
        Image { name: "another order", reversed: true, polar: same, axial: same, polar_back: same, axial_back: same };

    /// In a mirror across x.
    pub const MIRRORED: Image = Image {
        name: "mirror",
        reversed: false,
        polar: mirrored,
        axial: mirrored_axis,
        polar_back: mirrored,
        axial_back: mirrored_axis,
    };

    /// By a quarter turn about z.
    pub const TURNED: Image = Image {
        name: "quarter turn",
        reversed: false,
        polar: turned,
        axial: turned,
        polar_back: turned_back,
        axial_back: turned_back,
    };

    fn of(&self, drawn: &Drawn) -> Drawn {
        let mut image = drawn.mapped(self.polar, self.axial);
        if self.reversed {
            image.grains.reverse();
        }
        image
    }

    /// A snapshot of the image as one of the original.
    fn back(&self, snapshot: &Snapshot) -> Snapshot {
        let last = snapshot.particles.len() as u32 - 1;
        let id = |id: u32| if self.reversed { last - id } else { id };
        let polar = |v: [f64; 3]| (self.polar_back)(v.into()).into();
        let mut particles = snapshot.particles.clone();
        for particle in &mut particles {
            particle.id = id(particle.id);
            particle.position = polar(particle.position);
            particle.velocity = polar(particle.velocity);
            particle.spin = (self.axial_back)(particle.spin.into()).into();
        }
        particles.sort_by_key(|particle| particle.id);
        let contact = |contact: &Contact| Contact {
            first: id(contact.first),
            second: match contact.second {
                Partner::Grain(second) => Partner::Grain(id(second)),
                wall => wall,
            },
            point: polar(contact.point),
            normal: polar(contact.normal),
            tangential_force: polar(contact.tangential_force),
            ..*contact
        };
        Snapshot {
            time: snapshot.time,
            particles,
            contacts: snapshot.contacts.iter().map(contact).collect(),
            driven_walls: snapshot.driven_walls.clone(),
            origins: snapshot.origins.clone(),
            passed: snapshot.passed,
            stage: snapshot.stage,
            beginnings: snapshot.beginnings.clone(),
            ..Snapshot::default()
        }
    }
}

/// Contacts that bear in either of two solutions.
fn either(one: &[Touch], other: &[Touch]) -> Vec<Touch> {
    let bearing = |touches: &[Touch]| touches.iter().filter(|touch| touch.along > 0.0).cloned().collect::<Vec<Touch>>();
    let mut union = bearing(one);
    for touch in bearing(other) {
        let same = |known: &Touch| {
            known.first == touch.first && known.second == touch.second && known.normal.dot(&touch.normal) > 0.9
        };
        if !union.iter().any(same) {
            union.push(touch);
        }
    }
    union
}

/// Counts the steps with contacts that were compared, those among them whose velocities are unique, and those whose velocities
/// are known to [`SHARP`].
pub fn check(drawn: &Drawn, image: &Image) -> Result<[u64; 3], TestCaseError> {
    let mut run = drawn.start(Solves::Usual);
    let mut counts = [0; 3];
    for number in 0..STEPS {
        let state = run.snapshot();
        run.step();
        if number % STRIDE != 0 || run.snapshot().contacts.is_empty() {
            continue;
        }
        let Some(here) = drawn.starting_at(&state) else { break };
        let there = image.of(&here);
        let laws = Laws::new(&here, &here.scene(Solves::Converged));
        let one = step(&mut here.start(Solves::Converged), &laws);
        let mapped = {
            let laws = Laws::new(&there, &there.scene(Solves::Converged));
            step(&mut there.start(Solves::Converged), &laws)
        };
        if one.touches.is_empty() && mapped.touches.is_empty() {
            continue;
        }
        counts[0] += 1;
        // The image's solution as one of the original's problem; what it misses the laws by stays what it was.
        let after = image.back(&mapped.after);
        let touches = laws.touches(&one.before, &after, &one.kept);
        let inexact = mapped.inexact.rounded(&touches, drawn.step, farthest(&one.before));
        let other = Stepped { before: one.before.clone(), after, touches, inexact, struck: 0, kept: one.kept.clone() };
        for solution in [&one, &other] {
            for touch in &solution.touches {
                let (Some(law), Some(asked)) = (touch.law, touch.asked()) else { continue };
                let off = (touch.opening() - asked).min(touch.along * (touch.inverse_mass + law.regularisation)).abs();
                prop_assert!(
                    off <= solution.inexact.normal,
                    "step {number}: {off:e} m/s off the normal law: {touch:?}"
                );
                let sliding = touch.sliding();
                let off = touch.tangential.dot(&sliding) + drawn.friction * touch.along * sliding.norm();
                let bound = touch.friction_slack(drawn.friction, solution.inexact);
                prop_assert!(off <= bound, "step {number}: {off:e} J off Coulomb's law, {bound:e} at most: {touch:?}");
            }
        }
        let Some(factor) = factor(&either(&one.touches, &other.touches), &laws, drawn.friction) else { continue };
        counts[1] += 1;
        let bound = factor * miss(drawn.friction, [(&one.touches, one.inexact), (&other.touches, other.inexact)]);
        // Twice the kinetic energy of the difference of the two velocities, and of the velocities themselves.
        let (mut apart, mut fastest, mut lightest) = (0.0, 0.0_f64, f64::INFINITY);
        for (grain, (a, b)) in one.after.particles.iter().zip(&other.after.particles).enumerate() {
            let (v, w) = (Vector::from(a.velocity), Vector::from(b.velocity));
            let spin = (Vector::from(a.spin) - Vector::from(b.spin)) * a.radius;
            apart += laws.mass(grain) * ((v - w).norm_squared() + INERTIA * spin.norm_squared());
            (fastest, lightest) = (fastest.max(v.norm()), lightest.min(laws.mass(grain)));
        }
        // Velocities of grains that touch nothing are the same but for rounding.
        let rounding = laws.mass_of_all() * (1e-14 * fastest).powi(2);
        prop_assert!(
            apart <= bound + rounding,
            "step {number}: {:e} m/s apart in the {}, {:e} by the solves at most, of {fastest:e}",
            (apart / lightest).sqrt(),
            image.name,
            ((bound + rounding) / lightest).sqrt()
        );
        counts[2] += u64::from(((bound + rounding) / lightest).sqrt() < SHARP * fastest);
    }
    Ok(counts)
}
