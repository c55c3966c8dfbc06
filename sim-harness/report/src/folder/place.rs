//! Puts a directory of results in its place.

use std::ffi::OsString;
use std::fs;
use std::io;
use std::path::Path;

use super::list::{self, List};
use super::spot::{self, Spot};

/// Puts `staging` where `target` is asked for. Where that exists, both directories are exchanged in
/// one step of the file system; where it cannot be exchanged, the files are moved one by one.
pub(super) fn whole(
    staging: &Path,
    target: &Path,
    spot: &Spot,
    former: &List,
    new: &List,
) -> io::Result<()> {
    if !target.is_dir() {
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent)?;
        }
        return fs::rename(staging, target);
    }
    // What was put there since the command began is not this program's.
    let names = new.iter().chain([list::NAME]).filter(|name| !former.names(name));
    for name in names {
        if fs::symlink_metadata(target.join(name)).is_ok() {
            return Err(io::Error::new(
                io::ErrorKind::AlreadyExists,
                format!("{name} is there now"),
            ));
        }
    }
    if spot.is_beside && exchanged(staging, &spot.target, former) {
        clear_former(staging, &spot.target, former);
        return Ok(());
    }
    move_files(staging, target, former, new)
}

/// Exchanges both directories, unless the file system cannot. The user's own files are in the new
/// directory, too, before it takes the place.
fn exchanged(staging: &Path, target: &Path, former: &List) -> bool {
    let Ok(own) = foreign(target, former) else { return false };
    let mut linked = Vec::new();
    for name in own {
        // Directories cannot be linked.
        if fs::hard_link(target.join(&name), staging.join(&name)).is_err() {
            break;
        }
        linked.push(name);
    }
    let is_complete = foreign(target, former).is_ok_and(|own| own.len() == linked.len());
    if is_complete && exchange(staging, target).is_ok() {
        return true;
    }
    for name in linked {
        let _ = fs::remove_file(staging.join(name));
    }
    false
}

#[cfg(unix)]
fn exchange(one: &Path, other: &Path) -> io::Result<()> {
    use rustix::fs::{CWD, RenameFlags, renameat_with};
    renameat_with(CWD, one, CWD, other, RenameFlags::EXCHANGE).map_err(io::Error::from)
}

#[cfg(not(unix))]
fn exchange(_: &Path, _: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// The names in a directory that are not of its list.
fn foreign(directory: &Path, list: &List) -> io::Result<Vec<OsString>> {
    let mut names = Vec::new();
    for entry in fs::read_dir(directory)? {
        let name = entry?.file_name();
        let is_listed = name.to_str().is_some_and(|name| list.names(name));
        if !is_listed && !spot::is_temporary(&name) {
            names.push(name);
        }
    }
    Ok(names)
}

/// Removes a directory that was replaced by `target`: the files of its list, and of the user's own
/// the second name of those that are in `target`. Others are moved there, or else stay.
pub(super) fn clear_former(former: &Path, target: &Path, list: &List) {
    for name in foreign(former, list).unwrap_or_default() {
        let (old, new) = (former.join(&name), target.join(&name));
        if is_one_file(&old, &new) {
            let _ = fs::remove_file(old);
        } else if target.is_dir() && fs::symlink_metadata(&new).is_err() {
            let _ = fs::rename(old, new);
        }
    }
    for name in list.iter() {
        let _ = fs::remove_file(former.join(name));
    }
    // The list stays as long as anything else does: it says whose the directory is.
    let rest = fs::read_dir(former).map_or(0, Iterator::count);
    if rest <= 1 {
        let _ = fs::remove_file(former.join(list::NAME));
        let _ = fs::remove_dir(former);
    }
}

#[cfg(unix)]
fn is_one_file(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let number = |path| fs::symlink_metadata(path).map(|found| (found.dev(), found.ino())).ok();
    number(one).is_some() && number(one) == number(other)
}

#[cfg(not(unix))]
fn is_one_file(_: &Path, _: &Path) -> bool {
    false
}

/// Moves each file into the directory that is there. If the command is killed meanwhile, the list
/// names all files of either command.
fn move_files(staging: &Path, target: &Path, former: &List, new: &List) -> io::Result<()> {
    former.with(new).write(target)?;
    for name in new.iter() {
        fs::rename(staging.join(name), target.join(name))?;
    }
    for name in former.iter().filter(|name| !new.names(name)) {
        match fs::remove_file(target.join(name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    fs::rename(staging.join(list::NAME), target.join(list::NAME))?;
    fs::remove_dir(staging)
}
