//! Writes a report of invented numbers, to look at: `cargo run --example report_sample -- FOLDER`.

#[path = "../tests/support/sample.rs"]
mod sample;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("name a folder for the report")?;
    let mut qualification = sample::qualification(vec![sample::drum(true), sample::packing(), sample::alone()]);
    qualification.title = "Sample of a report: invented numbers".into();
    qualification.studies.push(sample::study(makadam_qualification::report::StudyOutcome::Failed));
    let page = makadam_qualification::report::write(&qualification, folder.as_ref())?;
    for comparison in &qualification.comparisons {
        println!("{}", makadam_qualification::report::comparison_table(comparison, true));
    }
    println!("{}", page.display());
    Ok(())
}
