//! Averages over time with an honest error: correlated frames are put into blocks.

use super::ensemble::{mean, standard_error};

/// Fewest frames in a block.
const FEWEST_FRAMES: usize = 4;

/// Most blocks: few and long, so that one block forgets the one before it.
const MOST_BLOCKS: usize = 5;

/// A mean over time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Average {
    /// Mean of all values.
    pub mean: f64,
    /// Standard error of the mean, from the spread of the means of blocks; absent for fewer than 8 values.
    pub standard_error: Option<f64>,
}

/// Number of blocks that `frames` frames are put into: five, or fewer so that a block holds at least four frames;
/// absent where there are not two blocks.
pub fn block_count(frames: usize) -> Option<usize> {
    let blocks = (frames / FEWEST_FRAMES).min(MOST_BLOCKS);
    (blocks >= 2).then_some(blocks)
}

/// Mean of consecutive values with the standard error over blocks of time (method of batch means).
///
/// Blocks are as equal in length as the number of values allows.
pub fn block_average(values: &[f64]) -> Average {
    let blocks = block_count(values.len()).map(|blocks| {
        let part = |block: usize| &values[block * values.len() / blocks..(block + 1) * values.len() / blocks];
        (0..blocks).map(|block| mean(part(block))).collect::<Vec<f64>>()
    });
    Average { mean: mean(values), standard_error: blocks.and_then(|means| standard_error(&means)) }
}
