//! Measures repairs of scenes whose holes are known.
//!
//! [`case`] lists the scenes, [`prepare`] makes them (with the tool `scene`, then [`rework`] gives them other heights and
//! disturbed rims), [`run`] repairs each with every method in a process of its own, [`measure`] compares the result with the
//! truth, and [`report`] and [`picture`] write tables and pictures. [`peers`] runs other programs on the same scenes.

pub mod case;
pub mod dem;
pub mod locate;
pub mod measure;
pub mod npz;
pub mod peers;
pub mod picture;
pub mod prepare;
pub mod report;
pub mod rework;
pub mod run;
pub mod scene_files;
pub mod slope;
