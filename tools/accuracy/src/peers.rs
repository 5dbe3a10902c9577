//! Other programs on the same scenes, by way of a script that runs them.

use crate::npz::read_array;
use crate::run::Cost;
use anyhow::{Context, Result, bail, ensure};
use glam::DVec3;
use std::path::Path;
use std::process::Command;

/// Where the script's Python and the script are.
#[derive(Clone, Copy, Debug)]
pub struct Peers<'a> {
    /// Python with the programs' packages.
    pub python: &'a Path,
    /// Folder of `peers.py`.
    pub check: &'a Path,
}

/// Triangles of a patch.
pub type PatchTriangles = Vec<[DVec3; 3]>;

impl Peers<'_> {
    /// Fills a made scene of PLY tiles with the program `name`; `work` is a folder for what lies between. Time is that of
    /// reading, merging, building and filling; memory the larger peak of the two processes.
    ///
    /// # Errors
    /// A script that fails or a program that it could not run.
    pub fn fill(&self, name: &str, scene: &Path, work: &Path) -> Result<(PatchTriangles, Cost)> {
        std::fs::create_dir_all(work)?;
        count_vertices(&scene.join("scene.json"))?;
        let result = work.join("result");
        let script = self.check.join("peers.py");
        let run = Command::new(self.python)
            .arg(&script)
            .arg(scene)
            .args(["--reps", "1", "--peers", name])
            .arg("--agg")
            .arg(work)
            .arg("--out")
            .arg(&result)
            .output()
            .with_context(|| self.python.display().to_string())?;
        let said = String::from_utf8_lossy(&run.stderr);
        ensure!(
            run.status.success(),
            "{}: {}",
            script.display(),
            said.trim().lines().last().unwrap_or_default()
        );
        let text = std::fs::read_to_string(result.with_extension("json"))?;
        let json: serde_json::Value = serde_json::from_str(&text)?;
        let (peer, merge) = (&json["peers"][name], &json["aggregate"]);
        if let Some(problem) = peer["error"].as_str() {
            bail!("{problem}");
        }
        let number = |value: &serde_json::Value| value.as_f64().unwrap_or(0.0);
        let cost = Cost {
            seconds: number(&merge["load"])
                + number(&merge["merge"])
                + number(&peer["build"])
                + number(&peer["fill"]),
            peak_mib: number(&merge["rss_mb"]).max(number(&peer["rss_mb"])),
        };
        Ok((read_patch(&work.join(format!("{name}.npz")))?, cost))
    }
}

/// The script wants the number of vertices in `scene.json`.
fn count_vertices(path: &Path) -> Result<()> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let mut scene: serde_json::Value = serde_json::from_str(&text)?;
    let cells = scene["cells"].as_array().map_or(&[][..], Vec::as_slice);
    let vertices: u64 = cells.iter().filter_map(|c| c["vertices"].as_u64()).sum();
    scene["vertices"] = vertices.into();
    std::fs::write(path, scene.to_string()).with_context(|| path.display().to_string())
}

fn read_patch(path: &Path) -> Result<PatchTriangles> {
    let (vertices, faces) = (read_array(path, "V.npy")?, read_array(path, "F.npy")?);
    ensure!(
        vertices.columns == 3 && faces.columns == 3,
        "{}: V and F have three columns each",
        path.display()
    );
    let corner = |v: &f64| {
        let row = vertices.values.get(3 * *v as usize..3 * *v as usize + 3)?;
        Some(DVec3::new(row[0], row[1], row[2]))
    };
    let triangle = |f: &[f64]| Some([corner(&f[0])?, corner(&f[1])?, corner(&f[2])?]);
    faces
        .values
        .chunks_exact(3)
        .map(|f| triangle(f).with_context(|| format!("{}: a face names no vertex", path.display())))
        .collect()
}
