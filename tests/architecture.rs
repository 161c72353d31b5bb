//! The house rules, checked: a module imports only from layers below its own,
//! and what a layer must not know stays out of it.

#![expect(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on says where")]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};

/// The modules of each layer, lowest first; `docs/ARCHITECTURE.md` says what
/// they hold.
const LAYERS: &[&[&str]] = &[
    &["math", "budget", "fault"],
    &["geometry", "optimize", "planner"],
    &["robot", "scene"],
    &["trajectory", "collision"],
    &["plan"],
    &["job", "picture"],
    &["service", "reproduce"],
    &["store", "http", "grpc"],
    &["config"],
    &["app"],
    &["cli"],
];

/// Crates that only some modules may name.
const RESERVED: &[(&str, &[&str])] = &[
    ("rusqlite", &["store"]),
    ("axum", &["http", "grpc", "app"]),
    ("tonic", &["grpc", "app", "cli"]),
    ("prost", &["grpc"]),
    ("prost_types", &["grpc"]),
    ("plotters", &["picture"]),
    ("clap", &["cli"]),
    ("indicatif", &["cli"]),
    ("reqwest", &["cli"]),
    ("roxmltree", &["robot"]),
    ("saphyr_parser", &["robot"]),
];

/// Modules that run without a runtime, files or network.
const PURE: &[&str] = &[
    "math",
    "budget",
    "fault",
    "geometry",
    "optimize",
    "planner",
    "robot",
    "scene",
    "trajectory",
    "collision",
    "plan",
    "picture",
    "reproduce",
];

fn layer(module: &str) -> Option<usize> {
    LAYERS.iter().position(|modules| modules.contains(&module))
}

fn rust_files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Paths a file names, as segments from the crate's root or an extern crate.
struct Names {
    /// The file's own module path, such as `["plan", "verify"]`.
    module: Vec<String>,
    paths: BTreeSet<Vec<String>>,
}

impl Names {
    /// `crate::a::b`, `self::c` and `super::d` as paths from the root.
    fn record(&mut self, segments: Vec<String>) {
        let Some(first) = segments.first() else { return };
        let resolved = match first.as_str() {
            "crate" => [vec!["crate".to_owned()], segments[1..].to_vec()].concat(),
            "self" | "super" => {
                let ups = segments.iter().take_while(|segment| *segment == "super").count();
                let skip = ups.max(1);
                let base = &self.module[..self.module.len().saturating_sub(ups)];
                [vec!["crate".to_owned()], base.to_vec(), segments[skip..].to_vec()].concat()
            }
            _ => segments,
        };
        self.paths.insert(resolved);
    }

    fn use_tree(&mut self, tree: &syn::UseTree, before: &[String]) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        match tree {
            syn::UseTree::Path(path) => self.use_tree(&path.tree, &with(&path.ident)),
            syn::UseTree::Name(name) => self.record(with(&name.ident)),
            syn::UseTree::Rename(rename) => self.record(with(&rename.ident)),
            syn::UseTree::Glob(_) => self.record(before.to_vec()),
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    self.use_tree(tree, before);
                }
            }
        }
    }
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.use_tree(&item.tree, &[]);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.record(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit::visit_path(self, path);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        self.module.push(item.ident.to_string());
        visit::visit_item_mod(self, item);
        self.module.pop();
    }
}

/// Every source file's module path and the paths it names.
fn sources() -> Vec<(PathBuf, Vec<String>, BTreeSet<Vec<String>>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    rust_files(&root, &mut files);
    files.sort();
    let study = |path: PathBuf| {
        let relative = path.strip_prefix(&root).unwrap().with_extension("");
        let mut module: Vec<String> =
            relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
        if module.last().is_some_and(|last| last == "mod") {
            module.pop();
        }
        let file = syn::parse_file(&fs::read_to_string(&path).unwrap())
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let mut names = Names { module: module.clone(), paths: BTreeSet::new() };
        names.visit_file(&file);
        (path, module, names.paths)
    };
    files.into_iter().map(study).collect()
}

#[test]
fn no_module_imports_from_its_own_layer_or_above() {
    let mut wrong = Vec::new();
    for (path, module, names) in sources() {
        if matches!(module[0].as_str(), "lib" | "main") {
            continue;
        }
        let Some(own) = layer(&module[0]) else {
            panic!("{} is in no layer", path.display());
        };
        for name in names.iter().filter(|name| name[0] == "crate" && name.len() > 1) {
            if let Some(theirs) = layer(&name[1])
                && name[1] != module[0]
                && theirs >= own
            {
                wrong.push(format!("{} names {}", path.display(), name.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn reserved_crates_stay_where_they_belong() {
    let mut wrong = Vec::new();
    for (path, module, names) in sources() {
        for name in &names {
            let reserved = RESERVED.iter().find(|(reserved, _)| name[0] == *reserved);
            if reserved.is_some_and(|(_, owners)| !owners.contains(&module[0].as_str())) {
                wrong.push(format!("{} names {}", path.display(), name.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn pure_layers_read_no_clock_and_do_no_io() {
    let forbidden: &[&[&str]] = &[
        &["std", "fs"],
        &["std", "net"],
        &["std", "process"],
        &["std", "env"],
        &["std", "time", "Instant"],
        &["std", "time", "SystemTime"],
        &["tokio"],
        &["jiff"],
        &["println"],
    ];
    let mut wrong = Vec::new();
    for (path, module, names) in sources() {
        if !PURE.contains(&module[0].as_str()) || module[0] == "budget" {
            continue;
        }
        for name in &names {
            if forbidden.iter().any(|start| {
                name.iter().zip(*start).all(|(a, b)| a == b) && name.len() >= start.len()
            }) {
                wrong.push(format!("{} names {}", path.display(), name.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The scan itself must see what it is meant to see.
#[test]
fn the_scan_sees_grouped_and_relative_paths() {
    let file = syn::parse_file(
        "use crate::{store::A, job::{self, B}}; use super::super::http::C; fn f() { crate::cli::run(); }",
    )
    .unwrap();
    let mut names = Names { module: vec!["plan".into(), "verify".into()], paths: BTreeSet::new() };
    names.visit_file(&file);
    let has =
        |path: &str| names.paths.contains(&path.split("::").map(str::to_owned).collect::<Vec<_>>());
    for path in ["crate::store::A", "crate::job::B", "crate::http::C", "crate::cli::run"] {
        assert!(has(path), "{path} not in {:?}", names.paths);
    }
}
