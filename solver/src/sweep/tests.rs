//! The page on the sweep's instructions says what there is.

use super::residual::Total;
use super::single::SingleSweep;
use super::*;
use crate::effects::{Frictional, Frictionless, Rolling, RollingTwisting, Twisting};
use crate::lanes::disassembly::{address_of, kernels_at, knights_corner_mnemonics};
use std::collections::BTreeSet;

const PAGE: &str = include_str!("../../docs/kernel.md");

/// Names between backticks in the first and in the second column of the page's tables.
fn columns() -> [BTreeSet<&'static str>; 2] {
    let mut columns = [BTreeSet::new(), BTreeSet::new()];
    for row in PAGE.lines().filter(|line| line.starts_with("| `")) {
        let cells: Vec<_> = row.split('|').collect();
        for (column, cell) in columns.iter_mut().zip(&cells[1..]) {
            column.extend(cell.split('`').skip(1).step_by(2));
        }
    }
    columns
}

#[test]
fn the_page_lists_every_instruction_of_the_sweep() {
    let addresses = [
        address_of::<Sweep<'static, Frictionless, Off>>(),
        address_of::<Sweep<'static, Frictionless, Total>>(),
        address_of::<Sweep<'static, Frictionless, Directions>>(),
        address_of::<Sweep<'static, Frictional, Off>>(),
        address_of::<Sweep<'static, Frictional, Total>>(),
        address_of::<Sweep<'static, Frictional, Directions>>(),
        address_of::<Sweep<'static, Rolling, Off>>(),
        address_of::<Sweep<'static, Twisting, Off>>(),
        address_of::<Sweep<'static, RollingTwisting, Off>>(),
        address_of::<Sweep<'static, RollingTwisting, Total>>(),
        address_of::<Sweep<'static, RollingTwisting, Directions>>(),
        address_of::<SingleSweep<'static, Frictionless, Off>>(),
        address_of::<SingleSweep<'static, Frictionless, Total>>(),
        address_of::<SingleSweep<'static, Frictionless, Directions>>(),
        address_of::<SingleSweep<'static, Frictional, Off>>(),
        address_of::<SingleSweep<'static, Frictional, Total>>(),
        address_of::<SingleSweep<'static, Frictional, Directions>>(),
    ];
    let kernels = kernels_at(&addresses);
    assert_eq!(kernels.len(), addresses.len(), "kernels of the sweep found by address");
    let found: BTreeSet<_> = kernels.iter().flat_map(|kernel| kernel.mnemonics()).collect();
    assert!(found.contains("vsqrtpd"), "this is no sweep: {found:?}");
    let [listed, _] = columns();
    let missing: Vec<_> = found.iter().filter(|mnemonic| !listed.contains(mnemonic.as_str())).collect();
    assert!(missing.is_empty(), "docs/kernel.md does not list {missing:?}");
}

#[test]
fn counterparts_on_the_page_exist_on_knights_corner() {
    let known = knights_corner_mnemonics();
    let [_, counterparts] = columns();
    assert!(counterparts.contains("vrcp23ps"), "no counterparts were read: {counterparts:?}");
    let unknown: Vec<_> = counterparts.iter().filter(|mnemonic| !known.contains(**mnemonic)).collect();
    assert!(unknown.is_empty(), "not instructions of Knights Corner: {unknown:?}");
}
