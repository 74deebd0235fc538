//! Unit tests of `src/study/table.rs`.

use super::*;

#[test]
fn a_file_has_full_precision_and_a_head_without_rows() {
    let table = Table::named("code, seconds sweeps within");
    assert_eq!(table.csv("empty").unwrap(), ("empty.csv".into(), b"\"code,\",seconds,sweeps,within\n".to_vec()));
    let rows = [("=a", Some(0.1 + 0.2), true), ("b", None, false)];
    let table = Table::named("code seconds sweeps within").of(rows, |row| cells![row.0, row.1, 3_u32, row.2]);
    let (_, written) = table.csv("full").unwrap();
    let expected = "code,seconds,sweeps,within\n'=a,0.30000000000000004,3,true\nb,,3,false\n";
    assert_eq!(String::from_utf8(written).unwrap(), expected);
}

#[test]
fn one_table_is_shown_in_three_ways() {
    let mut table = Table::new(&["code"], &["s"]).on_a_page(&["seconds"]).with_words("verdict");
    table.first_row(["a<b".into(), Cell::from("12").above(Some("11 to 13".into())), "within".into()]);
    table.row([Cell::from("c").marked("code-c"), None::<String>.into(), Cell::from("beyond").strong(true)]);
    assert_eq!(table.text(), "code   s  verdict\na<b   12  within\nc      -  beyond *\n");
    assert_eq!(
        table.markdown(),
        "| code | seconds | verdict |\n| --- | --- | --- |\n| a<b | 12 | within |\n| c |  | **beyond** |\n"
    );
    let html = table.html();
    for part in [
        "<th>code</th><th class=\"num\">seconds</th><th>verdict</th>",
        "<tr class=\"first\"><th scope=\"row\">a&lt;b</th><td class=\"num\">12<span class=\"interval\">11 to 13</span></td>",
        "<th scope=\"row\"><span class=\"swatch code-c\"></span>c</th><td class=\"num\">–</td>",
        "<strong>beyond</strong>",
    ] {
        assert!(html.contains(part), "{part} in\n{html}");
    }
}
