//! Runs the built program, and watches over the scenes that it reads.
#![allow(dead_code, unused_imports, reason = "each test uses a part of it")]

pub(crate) mod out;
pub(crate) mod run;
pub(crate) mod scene_folder;

pub(crate) use out::{digest, files_in, report, same_bytes};
pub(crate) use run::{Run, lacuna, repair};
pub(crate) use scene_folder::{SceneFolder, copy_tree, small};
