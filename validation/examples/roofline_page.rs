//! Draws a recorded roofline again: `roofline_page FOLDER` reads its roofline.json and writes page, figures and tables.

use makadam_validation::roofline::{Study, table};
use makadam_validation::study::Document;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: roofline_page FOLDER")?;
    let folder = Path::new(&folder);
    let study: Study = serde_json::from_slice(&std::fs::read(folder.join("roofline.json"))?)?;
    let page = study.write(folder)?;
    println!("{}\npage: {}", table(&study), page.display());
    Ok(())
}
