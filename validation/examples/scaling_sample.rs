//! Writes a scaling study of invented traces, to look at: `cargo run --example scaling_sample -- FOLDER`.

use makadam_validation::study::Document;

#[path = "../tests/support/scaling_sample.rs"]
mod sample;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("name a folder for the study")?;
    let study = sample::study();
    let page = study.write(folder.as_ref())?;
    println!("{}\n{}", makadam_validation::scaling::table(&study), page.display());
    Ok(())
}
