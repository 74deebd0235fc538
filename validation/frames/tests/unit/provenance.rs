//! Unit tests of `src/provenance.rs`.

use super::*;
use std::time::Duration;

#[test]
fn a_machine_is_its_processor_and_more() {
    assert!(machine().starts_with(&processor()) && machine().len() == processor().len() + 17);
    assert_eq!(machine(), machine());
}

#[test]
fn times_are_written_as_utc() {
    assert_eq!(utc(UNIX_EPOCH), "1970-01-01T00:00:00Z");
    assert_eq!(utc(UNIX_EPOCH + Duration::from_secs(951_782_399)), "2000-02-28T23:59:59Z");
    assert_eq!(utc(UNIX_EPOCH + Duration::from_secs(951_782_400)), "2000-02-29T00:00:00Z");
    assert_eq!(utc(UNIX_EPOCH + Duration::from_secs(4_107_542_400)), "2100-03-01T00:00:00Z");
}

#[test]
fn peak_memory_is_known() {
    assert!(peak_bytes() > 100_000);
}
