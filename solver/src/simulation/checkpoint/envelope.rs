//! What a file of ours is wrapped in: what kind it is, how long it is, and a checksum.

/// Bytes before the body: a mark of eight bytes, the length of the body and its checksum.
const HEAD: usize = 24;

/// Puts a mark, the length and the checksum before a body. The last byte of a mark is the version of what follows.
pub fn seal(mark: [u8; 8], body: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD + body.len());
    bytes.extend(mark);
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(checksum(body).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// The body of what [`seal`] made.
///
/// # Errors
/// What is wrong: it is too short, another kind of file or version, cut off, or damaged.
pub fn open(mark: [u8; 8], bytes: &[u8]) -> Result<&[u8], String> {
    let number = |at: usize| bytes[at..at + 8].try_into().map(u64::from_le_bytes).unwrap_or_default();
    if bytes.len() < HEAD {
        return Err(format!("is too short: {} bytes", bytes.len()));
    }
    if bytes[..7] != mark[..7] {
        return Err("is no such file: its first bytes are others".into());
    }
    if bytes[7] != mark[7] {
        return Err(format!("has version {} of the format, not {}", bytes[7], mark[7]));
    }
    let (length, body) = (number(8), &bytes[HEAD..]);
    if length != body.len() as u64 {
        return Err(format!("is cut off: it holds {} of {length} bytes", body.len()));
    }
    if number(16) != checksum(body) {
        return Err("is damaged: its checksum does not fit".into());
    }
    Ok(body)
}

/// FNV-1a, 64 bits (G. Fowler, L. C. Noll, K.-P. Vo).
pub fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    const MARK: [u8; 8] = *b"example\x03";

    #[test]
    fn every_change_of_a_sealed_file_is_noticed() {
        let sealed = seal(MARK, b"some body");
        assert_eq!(open(MARK, &sealed).unwrap(), b"some body");
        for place in 0..sealed.len() {
            for bit in 0..8 {
                let mut changed = sealed.clone();
                changed[place] ^= 1 << bit;
                assert!(open(MARK, &changed).is_err(), "bit {bit} of byte {place}");
            }
            assert!(open(MARK, &sealed[..place]).is_err(), "cut at {place}");
        }
        let longer = [sealed.as_slice(), b"x"].concat();
        assert!(open(MARK, &longer).unwrap_err().contains("cut off"));
        assert!(open(*b"example\x04", &sealed).unwrap_err().contains("version 3"));
    }
}
