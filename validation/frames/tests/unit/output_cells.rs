//! Unit tests of `src/output/cells.rs`.

use super::*;

#[test]
fn what_begins_as_a_formula_is_text_and_numbers_stay() {
    let table = "name,value\n=1+2,-3.5e-7\n\"@a,b\",+inf\n-wall,-\nplain,=\n";
    let safe = String::from_utf8(without_formulas(table.into())).unwrap();
    assert_eq!(safe, "name,value\n'=1+2,-3.5e-7\n\"'@a,b\",+inf\n'-wall,'-\nplain,'=\n");
    let plain = b"name,value\na,-1\n".to_vec();
    assert_eq!(without_formulas(plain.clone()), plain, "not a byte changes without need");
    for cell in ["=1+2", "-wall", "plain", "'quoted"] {
        let table = String::from_utf8(without_formulas(format!("{cell}\n").into())).unwrap();
        assert_eq!(as_meant(table.trim_end()), cell);
    }
}
