//! Damage to documents: every edit follows from one number, so that an input can be made again from its numbers.

/// Input that breaks readers: texts that are not numbers; huge, tiny, negative numbers; brackets; other alphabets.
const TOKENS: [&str; 32] = [
    "nan",
    "inf",
    "-inf",
    "NaN",
    "1e999",
    "-1e999",
    "1e308",
    "-0",
    "0",
    "-1",
    "1",
    "1e18",
    "1000000000000000000",
    "18446744073709551615",
    "18446744073709551616",
    "9223372036854775807",
    "-9223372036854775808",
    "1e-320",
    "4294967296",
    "256",
    "0.1",
    "1e-9",
    "[[",
    "]]",
    "{",
    "}",
    "\"",
    "'",
    "\n",
    "\u{0}",
    "\u{feff}",
    "grösse 粒",
];

/// Numbers that may well stand in the place of another: they lead past the checks.
const ORDINARY: [&str; 12] = ["0.001", "0.003", "0.01", "0.02", "0.5", "1.0", "2", "3", "10.0", "1e3", "-0.01", "1e5"];

/// Nested brackets, and their depth.
const NESTS: [&str; 5] = ["[", "{a=", "{\"a\":", "a.", "[["];
const DEPTH: usize = 3000;

/// Numbers of eight bytes that break readers.
const BITS: [u64; 10] = [
    0x7ff8_0000_0000_0000,
    0x7ff0_0000_0000_0000,
    0xfff0_0000_0000_0000,
    0x7fef_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0x0000_0000_0000_0001,
    0x43e0_0000_0000_0000,
    0xbff0_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
    0,
];

/// Longest document that damage makes.
const LONGEST: usize = 1 << 16;

/// Steele, Lea and Flood's SplitMix64.
pub struct Random(pub u64);

impl Random {
    /// The next number.
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    /// A number below a bound; zero if the bound is.
    pub fn below(&mut self, bound: usize) -> usize {
        if bound == 0 { 0 } else { (self.next() % bound as u64) as usize }
    }
}

/// Damages a document once; `others` are documents that parts are taken from.
pub fn damage(bytes: &mut Vec<u8>, others: &[Vec<u8>], edit: u64) {
    let mut random = Random(edit);
    let at = random.below(bytes.len() + 1);
    let length = [1, 2, 8, 30, 200][random.below(5)];
    let end = (at + length).min(bytes.len());
    match random.below(16) {
        0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
        1 if at < bytes.len() => bytes[at] = random.next() as u8,
        2 => drop(bytes.drain(at..end)),
        3 => {
            let copy = bytes[at..end].to_vec();
            let to = random.below(bytes.len() + 1);
            bytes.splice(to..to, copy);
        }
        4 => {
            let other = &others[random.below(others.len())];
            let from = random.below(other.len() + 1);
            let part = other[from..(from + length).min(other.len())].to_vec();
            bytes.splice(at..end, part);
        }
        5 => drop(bytes.splice(at..at, TOKENS[random.below(TOKENS.len())].bytes())),
        6 | 7 | 12..16 => {
            // A whole number in a text gives way to another one.
            let from = (at..bytes.len()).find(|&place| bytes[place].is_ascii_digit()).unwrap_or(at);
            let is_part = |byte: &u8| byte.is_ascii_digit() || b".e+-".contains(byte);
            let past = (from..bytes.len()).find(|&place| !is_part(&bytes[place])).unwrap_or(bytes.len());
            let number = if random.below(2) == 0 {
                TOKENS[random.below(TOKENS.len())]
            } else {
                ORDINARY[random.below(ORDINARY.len())]
            };
            bytes.splice(from..past, number.bytes());
        }
        8 => bytes.truncate(at),
        9 => {
            // A line goes, or comes twice.
            let start = bytes[..at].iter().rposition(|&byte| byte == b'\n').map_or(0, |place| place + 1);
            let stop = (at..bytes.len()).find(|&place| bytes[place] == b'\n').map_or(bytes.len(), |place| place + 1);
            let line: Vec<u8> = bytes.drain(start..stop).collect();
            if random.below(2) == 0 {
                bytes.splice(start..start, [line.clone(), line].concat());
            }
        }
        10 => {
            let number = BITS[random.below(BITS.len())].to_le_bytes();
            let from = if random.below(2) == 0 { at / 8 * 8 } else { at };
            bytes.splice(from..(from + 8).min(bytes.len()), number);
        }
        _ if random.below(20) == 0 => {
            let nest = NESTS[random.below(NESTS.len())].repeat(1 + random.below(DEPTH));
            bytes.splice(at..at, nest.into_bytes());
        }
        _ => drop(bytes.splice(at..end, (0..length).map(|_| random.next() as u8))),
    }
    bytes.truncate(LONGEST);
}

/// The input of a number: every eighth is arbitrary bytes, the others are documents with one to six damages.
pub fn input(documents: &[Vec<u8>], number: u64) -> Vec<u8> {
    let mut random = Random(number);
    if random.below(8) == 0 {
        let length = random.below(600);
        return (0..length).map(|_| random.next() as u8).collect();
    }
    let mut bytes = documents[random.below(documents.len())].clone();
    let most = if random.below(2) == 0 { 1 } else { 6 };
    for _ in 0..1 + random.below(most) {
        damage(&mut bytes, documents, random.next());
    }
    bytes
}
