//! Builds the page into a folder that any web server hosts: `cargo run --package pack [FOLDER]`, in
//! `web/`; where no folder is given, `web/dist`. A folder with files that are not the page's is refused.
//!
//! The crate `wasm-bindgen-cli-support` is the library of the tool `wasm-bindgen`. As a dependency, its
//! version is that of the lock file, which must be the same as that of `wasm-bindgen`.

use std::error::Error;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use flate2::{Compression, write::GzEncoder};
use wasm_bindgen_cli_support::Bindgen;

const WEB: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/..");

/// The most that all files may take, compressed: a phone loads so much in some seconds.
const MOST_BYTES: usize = 4 << 20;

/// The files that are built, beside those of `page/`.
const BUILT: [&str; 2] = ["uchain_web.js", "uchain_web_bg.wasm"];

fn main() -> Result<(), Box<dyn Error>> {
    let web = Path::new(WEB).canonicalize()?;
    let folder = std::env::args_os().nth(1).map_or_else(|| web.join("dist"), PathBuf::from);
    let page = web.join("page");
    if folder.exists() {
        check(&folder, &page)?;
    }
    let wasm = compiled(&web)?;
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    let mut bindgen = Bindgen::new();
    bindgen.input_path(&wasm).web(true)?.typescript(false).remove_producers_section(true);
    bindgen.generate(&folder)?;
    for file in fs::read_dir(&page)? {
        let file = file?;
        fs::copy(file.path(), folder.join(file.file_name()))?;
    }
    sizes(&folder)
}

/// Refuses a folder that holds anything but an earlier page: all of its files are removed.
fn check(folder: &Path, page: &Path) -> Result<(), Box<dyn Error>> {
    let told = |error: std::io::Error| format!("{}: {error}", folder.display());
    let entries =
        fs::read_dir(folder).map_err(told)?.collect::<Result<Vec<_>, _>>().map_err(told)?;
    let is_built = |name: &OsStr| BUILT.iter().any(|built| name == *built);
    let names: Vec<_> = entries.iter().map(fs::DirEntry::file_name).collect();
    // A site of other making may have an `index.html` as well, but nothing that is built here.
    let is_page = names.iter().any(|name| is_built(name));
    let is_ours = |name: &OsStr| is_page && (is_built(name) || page.join(name).exists());
    let foreign = names.iter().find(|name| !is_ours(name));
    foreign.map_or(Ok(()), |name| {
        let name = name.display();
        let remedy = "give an empty folder, or remove what is not of the page";
        Err(format!("{}: {name} is not of an earlier page; {remedy}", folder.display()).into())
    })
}

/// Compiles the library, and returns the file.
fn compiled(web: &Path) -> Result<PathBuf, Box<dyn Error>> {
    let target = std::env::var_os("CARGO_TARGET_DIR");
    let target = target.map_or_else(|| web.join("target"), PathBuf::from);
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsStr::new("cargo").to_owned());
    let triple = "wasm32-unknown-unknown";
    let done = Command::new(cargo)
        .current_dir(web)
        .args(["build", "--locked", "--package", "uchain-web", "--lib", "--release"])
        .args(["--target", triple, "--target-dir"])
        .arg(&target)
        .status()?;
    if !done.success() {
        let remedy = format!("if the target is not installed, run `rustup target add {triple}`");
        return Err(format!("cargo could not build the page's WebAssembly; {remedy}").into());
    }
    Ok(target.join(triple).join("release").join("uchain_web.wasm"))
}

/// Prints what each file takes, and takes when a server compresses it.
fn sizes(folder: &Path) -> Result<(), Box<dyn Error>> {
    let mut files = fs::read_dir(folder)?.collect::<Result<Vec<_>, _>>()?;
    files.sort_by_key(fs::DirEntry::file_name);
    let mut all = [0; 2];
    println!("{:24} {:>10} {:>10}", folder.display(), "bytes", "gzip");
    for file in files {
        let bytes = fs::read(file.path())?;
        let mut packed = GzEncoder::new(Vec::new(), Compression::best());
        std::io::Write::write_all(&mut packed, &bytes)?;
        let sizes = [bytes.len(), packed.finish()?.len()];
        println!("{:24} {:10} {:10}", file.file_name().to_string_lossy(), sizes[0], sizes[1]);
        all = [all[0] + sizes[0], all[1] + sizes[1]];
    }
    println!("{:24} {:10} {:10}", "all", all[0], all[1]);
    if all[1] > MOST_BYTES {
        return Err(format!("the page takes more than {MOST_BYTES} bytes, compressed").into());
    }
    Ok(())
}
