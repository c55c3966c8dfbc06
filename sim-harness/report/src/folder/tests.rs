use super::*;

/// A directory of a test's own, gone when dropped.
pub(crate) struct Scratch(PathBuf);

impl Scratch {
    pub(crate) fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("uchain-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.0
    }

    /// Names and texts of the files in `out`, sorted; `None` if there is no such directory.
    fn out(&self) -> Option<Vec<(String, String)>> {
        let entries = fs::read_dir(self.0.join("out")).ok()?;
        let mut files: Vec<_> = entries
            .map(|entry| entry.unwrap())
            .filter(|entry| entry.file_name() != "files.txt")
            .map(|entry| {
                let text = fs::read_to_string(entry.path()).unwrap_or_default();
                (entry.file_name().into_string().unwrap(), text)
            })
            .collect();
        files.sort();
        Some(files)
    }

    /// The names beside `out`, hidden ones too.
    fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    fn command(&self, files: &[(&str, &str)]) -> Result<Vec<PathBuf>, InputError> {
        let mut folder = Folder::open(&self.0.join("out"))?;
        for (name, text) in files {
            folder.put_text(name, text)?;
        }
        folder.finish()
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn named(files: &[(&str, &str)]) -> Vec<(String, String)> {
    files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

#[test]
fn nothing_is_there_until_the_folder_is_finished() {
    let scratch = Scratch::new("unseen");
    let mut folder = Folder::open(&scratch.path().join("made/for/it")).unwrap();
    folder.put_text("a", "1").unwrap();
    assert!(!scratch.path().join("made").exists());
    folder.finish().unwrap();
    assert_eq!(fs::read_to_string(scratch.path().join("made/for/it/a")).unwrap(), "1");
}

#[test]
fn a_folder_that_is_dropped_leaves_the_former_one_and_no_other() {
    let scratch = Scratch::new("dropped");
    scratch.command(&[("a", "1")]).unwrap();
    let before = scratch.out();
    let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
    folder.put_text("a", "2").unwrap();
    drop(folder);
    assert_eq!(scratch.out(), before);
    drop(Folder::open(&scratch.path().join("new")).unwrap());
    assert_eq!(fs::read_dir(scratch.path()).unwrap().count(), 1, "only out is left");
}

#[test]
fn a_folder_that_is_discarded_cannot_be_finished() {
    let scratch = Scratch::new("discarded");
    let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
    folder.put_text("a", "1").unwrap();
    folder.staging().discard();
    assert!(folder.put_text("b", "1").is_err());
    assert!(folder.finish().is_err());
    assert_eq!(scratch.out(), None);
}

#[test]
fn a_later_command_replaces_what_the_former_wrote_and_nothing_else() {
    let scratch = Scratch::new("replaced");
    scratch.command(&[("a", "1"), ("b", "1")]).unwrap();
    fs::write(scratch.path().join("out/notes"), "mine").unwrap();
    scratch.command(&[("a", "2"), ("c", "2")]).unwrap();
    let expected = [("a", "2"), ("c", "2"), ("notes", "mine")];
    assert_eq!(scratch.out().unwrap(), named(&expected));
}

#[test]
fn a_file_that_the_program_did_not_write_is_never_replaced() {
    let scratch = Scratch::new("foreign");
    scratch.command(&[("a", "1")]).unwrap();
    fs::write(scratch.path().join("out/b"), "mine").unwrap();
    let before = scratch.out();
    let error = scratch.command(&[("a", "2"), ("b", "2")]).unwrap_err();
    assert!(error.to_string().contains("was not written by uchain"), "{error}");
    assert_eq!(scratch.out(), before);
}

#[test]
fn a_directory_of_other_files_is_refused_and_an_empty_one_is_not() {
    let scratch = Scratch::new("other");
    fs::create_dir(scratch.path().join("out")).unwrap();
    scratch.command(&[("a", "1")]).unwrap();
    fs::remove_file(scratch.path().join("out/files.txt")).unwrap();
    let error = scratch.command(&[("b", "2")]).unwrap_err();
    assert!(error.to_string().contains("give --out a new or an empty directory"), "{error}");
    assert_eq!(scratch.out().unwrap(), named(&[("a", "1")]));
}

/// The list of a directory of the user's own, with what this program writes into its list.
#[test]
fn a_list_cannot_name_a_file_elsewhere() {
    let scratch = Scratch::new("elsewhere");
    scratch.command(&[("a", "1")]).unwrap();
    let list = scratch.path().join("out/files.txt");
    fs::write(scratch.path().join("precious"), "mine").unwrap();
    let text = fs::read_to_string(&list).unwrap();
    for name in ["../precious", "..", "/etc", ""] {
        // The checksum and the size of that file: by them it would be one that this program wrote.
        let crc = crc32fast::hash(b"mine");
        fs::write(&list, format!("{text}{crc:08x} 4 {name}\n")).unwrap();
        let error = scratch.command(&[("a", "1")]).unwrap_err();
        assert!(error.to_string().contains("give --out a new or an empty directory"), "{error}");
    }
    assert_eq!(fs::read_to_string(scratch.path().join("precious")).unwrap(), "mine");
}

#[test]
fn a_directory_with_a_list_of_its_users_own_is_refused() {
    for text in ["summary.json\nmap.png\n", "", "# uchain", "# uchain is writing here"] {
        let scratch = Scratch::new("listed");
        let out = scratch.path().join("out");
        fs::create_dir(&out).unwrap();
        fs::write(out.join("files.txt"), text).unwrap();
        fs::write(out.join("summary.json"), "mine").unwrap();
        let error = scratch.command(&[("summary.json", "1")]).unwrap_err();
        assert!(error.to_string().contains("give --out a new or an empty directory"), "{error}");
        assert_eq!(fs::read_to_string(out.join("summary.json")).unwrap(), "mine");
        assert_eq!(fs::read_to_string(out.join("files.txt")).unwrap(), text);
        assert_eq!(scratch.names(), ["out"]);
    }
}

#[test]
fn a_file_that_was_changed_since_it_was_written_is_neither_replaced_nor_removed() {
    for later in [("a", "3"), ("b", "3")] {
        let scratch = Scratch::new("changed");
        scratch.command(&[("a", "1")]).unwrap();
        fs::write(scratch.path().join("out/a"), "2").unwrap();
        let error = scratch.command(&[later]).unwrap_err();
        assert!(error.to_string().contains("is not as uchain wrote it"), "{error}");
        assert_eq!(scratch.out().unwrap(), named(&[("a", "2")]));
    }
}

#[test]
#[cfg(unix)]
fn a_file_that_was_changed_while_the_command_ran_is_not_replaced_either() {
    let scratch = Scratch::new("changed-late");
    scratch.command(&[("a", "1")]).unwrap();
    let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
    folder.put_text("a", "2").unwrap();
    fs::write(scratch.path().join("out/a"), "mine").unwrap();
    assert!(folder.finish().is_err());
    assert_eq!(scratch.out().unwrap(), named(&[("a", "mine")]));
}

/// A directory that appears while the command runs, with a file of the same name.
#[test]
fn a_file_that_appears_while_the_command_runs_is_not_replaced() {
    let scratch = Scratch::new("appeared");
    let mut folder = Folder::open(&scratch.path().join("out")).unwrap();
    folder.put_text("a", "1").unwrap();
    fs::create_dir(scratch.path().join("out")).unwrap();
    fs::write(scratch.path().join("out/a"), "mine").unwrap();
    assert!(folder.finish().is_err());
    assert_eq!(scratch.out().unwrap(), named(&[("a", "mine")]));
    assert_eq!(scratch.names(), ["out"]);
}

#[test]
fn two_commands_do_not_write_into_one_directory() {
    let scratch = Scratch::new("busy");
    for _ in 0..2 {
        let first = Folder::open(&scratch.path().join("out")).unwrap();
        let error = Folder::open(&scratch.path().join("out")).err().unwrap();
        assert!(error.to_string().contains("another uchain is writing"), "{error}");
        drop(first);
        // The second time there is a directory.
        scratch.command(&[("a", "1")]).unwrap();
    }
    assert_eq!(scratch.names(), ["out"]);
}

/// Whoever looks into the directory at any moment, as after a command that is killed then, finds the
/// results of one command, all of them.
#[test]
#[cfg(target_os = "linux")]
fn results_are_replaced_as_a_whole_or_not_at_all() {
    use std::os::fd::AsRawFd;
    use std::sync::atomic::{AtomicBool, Ordering};
    let scratch = Scratch::new("at-once");
    let out = scratch.path().join("out");
    scratch.command(&[("a", "0"), ("b", "0")]).unwrap();
    fs::write(out.join("notes"), "mine").unwrap();
    let is_done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let looker = scope.spawn(|| {
            let mut looks = 0;
            while !is_done.load(Ordering::Relaxed) {
                // The directory of this moment, under whatever name.
                let held = File::open(&out).expect("there is always one");
                let itself = PathBuf::from(format!("/proc/self/fd/{}", held.as_raw_fd()));
                let read = |name| fs::read_to_string(itself.join(name)).ok();
                let found = (read("a"), read("b"));
                // One that was replaced meanwhile is being cleared.
                if let (Some(a), Some(b)) = found {
                    assert_eq!(a, b, "of two commands");
                    looks += 1;
                }
            }
            looks
        });
        for n in 1..=300 {
            let text = n.to_string();
            let written = scratch.command(&[("a", &text), ("b", &text)]);
            if looker.is_finished() || written.is_err() {
                break;
            }
        }
        is_done.store(true, Ordering::Relaxed);
        assert!(looker.join().unwrap() > 0);
    });
    let expected = [("a", "300"), ("b", "300"), ("notes", "mine")];
    assert_eq!(scratch.out().unwrap(), named(&expected));
}

/// What is there after a command was killed at any step of its writing.
#[test]
fn what_a_killed_command_has_left_is_removed_by_the_next() {
    let unfinished = "# uchain is writing here, and removes this directory\n";
    for (text, others) in [(unfinished, true), (&unfinished[..9], false), ("", false)] {
        let scratch = Scratch::new("killed");
        scratch.command(&[("a", "1")]).unwrap();
        let left = scratch.path().join(".out.unfinished-results");
        fs::create_dir(&left).unwrap();
        fs::write(left.join("files.txt"), text).unwrap();
        if others {
            fs::write(left.join("trace.csv"), "half").unwrap();
        }
        fs::write(scratch.path().join(".out.uchain-lock"), "").unwrap();
        scratch.command(&[("a", "2")]).unwrap();
        assert_eq!(scratch.out().unwrap(), named(&[("a", "2")]));
        assert_eq!(scratch.names(), ["out"], "{text:?}");
    }
    let scratch = Scratch::new("killed-at-once");
    fs::create_dir(scratch.path().join(".out.unfinished-results")).unwrap();
    scratch.command(&[("a", "1")]).unwrap();
    assert_eq!(scratch.names(), ["out"]);
}

/// Killed after both directories were exchanged: the former one has the user's notes yet.
#[test]
fn the_users_files_come_back_from_a_directory_that_was_replaced() {
    let scratch = Scratch::new("exchanged");
    let (out, aside) = (scratch.path().join("out"), scratch.path().join("aside"));
    scratch.command(&[("a", "1")]).unwrap();
    fs::write(out.join("notes"), "mine").unwrap();
    fs::rename(&out, &aside).unwrap();
    scratch.command(&[("a", "2")]).unwrap();
    fs::rename(aside, scratch.path().join(".out.unfinished-results")).unwrap();
    scratch.command(&[("a", "3")]).unwrap();
    assert_eq!(scratch.out().unwrap(), named(&[("a", "3"), ("notes", "mine")]));
    assert_eq!(scratch.names(), ["out"]);
}

#[test]
fn a_directory_of_the_user_in_the_way_of_the_temporary_one_is_left_alone() {
    let scratch = Scratch::new("in-the-way");
    let own = scratch.path().join(".out.unfinished-results");
    fs::create_dir(&own).unwrap();
    fs::write(own.join("precious"), "mine").unwrap();
    assert!(scratch.command(&[("a", "1")]).is_err());
    assert_eq!(fs::read_to_string(own.join("precious")).unwrap(), "mine");
}

#[test]
fn the_users_directories_in_a_directory_of_results_stay() {
    let scratch = Scratch::new("nested");
    scratch.command(&[("a", "1"), ("b", "1")]).unwrap();
    fs::create_dir(scratch.path().join("out/mine")).unwrap();
    fs::write(scratch.path().join("out/mine/notes"), "mine").unwrap();
    scratch.command(&[("a", "2")]).unwrap();
    assert_eq!(fs::read_to_string(scratch.path().join("out/mine/notes")).unwrap(), "mine");
    assert_eq!(scratch.out().unwrap(), named(&[("a", "2"), ("mine", "")]));
    assert_eq!(scratch.names(), ["out"]);
}

#[test]
fn a_directory_that_cannot_be_is_bad_input() {
    let scratch = Scratch::new("blocked");
    let file = scratch.path().join("file");
    fs::write(&file, "").unwrap();
    for wrong in [file.join("out"), file, scratch.path().join("no/..")] {
        let error = Folder::open(&wrong).err().unwrap();
        assert!(error.to_string().contains("give --out a directory"), "{error}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
}
