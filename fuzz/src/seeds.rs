//! Writes the sound documents of every reader to `corpus/NAME`, for libFuzzer to start from.

use makadam_fuzz::readers::READERS;
use std::path::Path;

fn main() -> std::io::Result<()> {
    for reader in &READERS {
        let folder = Path::new("corpus").join(reader.name);
        std::fs::create_dir_all(&folder)?;
        for (number, document) in (reader.documents)().iter().enumerate() {
            std::fs::write(folder.join(format!("sound-{number}")), document)?;
        }
    }
    Ok(())
}
