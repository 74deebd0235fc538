//! How much arithmetic a contact sweep is, counted by running the kernel's own source over numbers that count.

use super::kernel::{Bodies, Contact, Pair, Spring};
use super::residual::{LaneResidual, Off};
use crate::effects::Frictional;
use crate::lanes::Number;
use serde::{Deserialize, Serialize};
use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Operations of one relaxation of one contact that measures no residual. A negation, a comparison and a selection are not
/// counted; a multiplication by 1 is, though a compiler may leave it out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Operations {
    /// Additions and subtractions.
    pub additions: u32,
    /// Multiplications.
    pub multiplications: u32,
    /// Divisions.
    pub divisions: u32,
    /// Square roots.
    pub square_roots: u32,
}

impl Operations {
    const NONE: Operations = Operations { additions: 0, multiplications: 0, divisions: 0, square_roots: 0 };

    /// Of a contact of two grains with friction.
    pub fn of_pair() -> Operations {
        counted(|contact| {
            let (mut first, mut second) = (Bodies::at_rest(), Bodies::at_rest());
            let pair = Pair::of(&first, &second);
            let nowhere = &mut LaneResidual::zero();
            let [impulse, lever] = contact.relax_pair::<Frictional, Off>(&pair, Counted(1.0), nowhere);
            first.push::<Frictional>(-1.0, impulse, lever);
            second.push::<Frictional>(1.0, impulse, lever);
        })
    }

    /// Of a contact of a grain with a wall, with friction.
    pub fn of_wall() -> Operations {
        let still = [Counted(0.0); 3];
        counted(|contact| {
            let mut grain = Bodies::at_rest();
            let nowhere = &mut LaneResidual::zero();
            let [impulse, lever] = contact.relax_wall::<Frictional, Off>(&grain, still, Counted(1.0), nowhere);
            grain.push::<Frictional>(-1.0, impulse, lever);
        })
    }

    /// All of them: each counts as one floating-point operation, though a division takes as long as many additions.
    pub fn total(&self) -> u32 {
        self.additions + self.multiplications + self.divisions + self.square_roots
    }
}

/// What a relaxation does from nothing.
fn counted(relax: impl FnOnce(&mut Contact<Counted>)) -> Operations {
    let zero = Counted(0.0);
    let mut contact = Contact {
        normal: [zero; 3],
        bias: zero,
        regularisation: zero,
        friction: zero,
        impulse_normal: zero,
        impulse_tangential: [zero; 3],
        spring: Spring { compliance: zero, bias: [zero; 3] },
    };
    DONE.set(Operations::NONE);
    relax(&mut contact);
    DONE.get()
}

thread_local! {
    static DONE: Cell<Operations> = const { Cell::new(Operations::NONE) };
}

/// A number that counts what is done to it on this thread.
#[derive(Clone, Copy)]
struct Counted(f64);

impl Counted {
    fn after(value: f64, operation: impl Fn(&mut Operations) -> &mut u32) -> Counted {
        let mut done = DONE.get();
        *operation(&mut done) += 1;
        DONE.set(done);
        Counted(value)
    }
}

impl Add for Counted {
    type Output = Counted;
    fn add(self, other: Counted) -> Counted {
        Counted::after(self.0 + other.0, |done| &mut done.additions)
    }
}

impl Sub for Counted {
    type Output = Counted;
    fn sub(self, other: Counted) -> Counted {
        Counted::after(self.0 - other.0, |done| &mut done.additions)
    }
}

impl Mul for Counted {
    type Output = Counted;
    fn mul(self, other: Counted) -> Counted {
        Counted::after(self.0 * other.0, |done| &mut done.multiplications)
    }
}

impl Div for Counted {
    type Output = Counted;
    fn div(self, other: Counted) -> Counted {
        Counted::after(self.0 / other.0, |done| &mut done.divisions)
    }
}

impl Neg for Counted {
    type Output = Counted;
    fn neg(self) -> Counted {
        Counted(-self.0)
    }
}

impl Number for Counted {
    type Mask = bool;

    fn splat(value: f64) -> Counted {
        Counted(value)
    }

    fn sqrt(self) -> Counted {
        Counted::after(self.0.sqrt(), |done| &mut done.square_roots)
    }

    fn abs(self) -> Counted {
        Counted(self.0.abs())
    }

    fn larger(self, other: Counted) -> Counted {
        Counted(Number::larger(self.0, other.0))
    }

    fn smaller(self, other: Counted) -> Counted {
        Counted(Number::smaller(self.0, other.0))
    }

    fn below(self, other: Counted) -> bool {
        self.0 < other.0
    }

    fn at_most(self, other: Counted) -> bool {
        self.0 <= other.0
    }

    fn select(mask: bool, yes: Counted, no: Counted) -> Counted {
        if mask { yes } else { no }
    }

    fn all(mask: bool) -> bool {
        mask
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: relative velocity 18, effective mass 1, normal impulse 12, its vector 3, tangential impulse 32, lever 9, and
    /// 14 for each body that takes the impulse; a wall has one body, one vector sum and the sum of masses less.
    #[test]
    fn the_count_is_that_of_the_formulas() {
        let (pair, wall) = (Operations::of_pair(), Operations::of_wall());
        assert_eq!(pair.total(), 18 + 1 + 12 + 3 + 32 + 9 + 2 * 14);
        assert_eq!(pair.total() - wall.total(), 3 + 1 + 14);
        assert_eq!((pair.divisions, pair.square_roots), (3, 1));
    }
}
