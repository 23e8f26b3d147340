//! Files that appear whole or not at all.

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

/// Writes `bytes` beside `path` and renames the result into place, so that a failure leaves what stood there before.
///
/// Something that is no regular file (a pipe, a device) is written to directly; a symbolic link stays one.
pub fn replace_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // Follow a link to the file it names
    let target = match path.metadata() {
        Ok(existing) if existing.is_dir() => {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder"));
        }
        Ok(existing) if !existing.is_file() => return std::fs::write(path, bytes),
        Ok(_) => path.canonicalize()?,
        Err(_) => path.to_path_buf(),
    };

    // Write beside it, then rename; take the unfinished file away if either fails
    let unfinished = beside(&target)?;
    let done = std::fs::write(&unfinished, bytes).and_then(|()| std::fs::rename(&unfinished, &target));
    if done.is_err() {
        let _ = std::fs::remove_file(&unfinished);
    }
    done
}

/// Finds out before any work whether [`replace_file`] could write there: no folder of that name, and the right to make files
/// beside it. A disk may still be full by then.
pub fn could_replace_file(path: &Path) -> io::Result<()> {
    let target = match path.metadata() {
        Ok(existing) if existing.is_dir() => {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "it is a folder; name a file in it"));
        }
        Ok(existing) if !existing.is_file() => return Ok(()),
        Ok(_) => path.canonicalize()?,
        Err(_) => path.to_path_buf(),
    };
    let unfinished = beside(&target)?;
    std::fs::File::create(&unfinished)?;
    std::fs::remove_file(&unfinished)
}

/// `.NAME.tmp-PID` in the same folder.
fn beside(target: &Path) -> io::Result<PathBuf> {
    let name = target.file_name().ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "no file name"))?;
    let mut hidden = OsString::from(".");
    hidden.push(name);
    hidden.push(format!(".tmp-{}", std::process::id()));
    Ok(target.with_file_name(hidden))
}
