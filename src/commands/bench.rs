//! `bhs bench`: tables of time against error.

use super::{Common, ExitStatus, load, print, show};
use crate::cli::BenchArgs;
use crate::lang::{self, Overrides, Variables};
use crate::memory;
use crate::output::{Kept, NamedBy, OutputFile, OutputSet, Plan, Rescue};
use crate::registry::Registry;
use crate::{report, say};
use anyhow::{Context, Result};
use serde_json::json;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// `bhs bench`
///
/// # Errors
/// If the scene cannot be measured or a file cannot be written.
pub fn bench(args: &BenchArgs, common: &Common) -> Result<ExitStatus> {
    if args.scene == Path::new("-") {
        // It is read several times.
        say!("error: `bhs bench` needs a file");
        return Ok(ExitStatus::CommandLine);
    }
    let overrides = Overrides { variables: Variables::defined(&args.definitions.define), ..Default::default() };
    // Integrators at the scene's own resolution, which sets what they need not tell apart.
    let Some((built, sources)) = load(&args.scene, &overrides, common) else { return Ok(ExitStatus::Fault) };
    let wanted = |what: &str| args.only.as_deref().is_none_or(|only| only == what);
    let mut files = BTreeMap::new();
    if let Some(folder) = &args.output {
        let mut plan = Plan::new(&sources);
        // In a folder that is not there yet, nothing can be in the way.
        let names: Vec<String> = if folder.exists() { file_names(wanted).collect() } else { Vec::new() };
        names.iter().for_each(|name| drop(plan.claim(&folder.join(name), NamedBy::CommandLine)));
        if let Err(found) = plan.finish() {
            show(&found, &sources, common.color);
            return Ok(ExitStatus::Fault);
        }
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder `{}`", folder.display()))?;
        for name in file_names(wanted) {
            let file = OutputFile::reserve(&folder.join(&name))?;
            files.insert(name, file);
        }
    }
    drop(sources);
    // Camera rays and what bounces of them, what sorts them, and where they end by two integrators.
    memory::require("the rays", u64::from(args.rays) * 1000)?;
    let hash = built.hash.clone();
    let mut measured = Vec::new();
    if wanted("integrators") {
        measured.extend(crate::bench::integrators::measure(&built, args.rays as usize, args.rounds));
    }
    if wanted("transports") {
        // The pictures' own resolution sets what rays need not tell apart; all of them share one scene.
        drop(built);
        let variables = overrides.variables.clone();
        let overrides = Overrides { resolution: Some(args.resolution), ..overrides };
        let Some((small, _)) = load(&args.scene, &overrides, common) else { return Ok(ExitStatus::Fault) };
        let registry = Registry::builtin();
        let make = |overrides: &Overrides| {
            let mut sources = common.sources();
            let overrides = Overrides { variables: variables.clone(), ..overrides.clone() };
            lang::load_method(&args.scene, &registry, &overrides, &mut sources)
                .map_err(|found| anyhow::anyhow!("{}", report::render(&found, &sources, common.color)))
        };
        measured.push(crate::bench::transports::measure(small, make, args.rounds)?);
    }
    let mut text = String::new();
    if args.json {
        let tables: serde_json::Map<_, _> =
            measured.iter().flat_map(|m| m.tables()).map(|(name, table)| (name, table.to_json())).collect();
        text = serde_json::to_string_pretty(&json!({ "scene": hash, "tables": tables }))? + "\n";
    } else {
        for m in &measured {
            text += &format!("{}\n\n{}\n", m.chart.title, m.table.to_markdown());
            if let Some(summary) = &m.summary {
                text += &format!("{}, {}\n\n{}\n", m.name.replace('_', " "), summary.title, summary.table.to_markdown());
            }
        }
    }
    let printed = print(&text);
    // Files are written even if nobody reads the tables.
    let mut set = OutputSet::new();
    for m in &measured {
        let tables = m.tables().map(|(name, table)| (format!("{name}.csv"), table.to_csv()));
        for (name, text) in tables.chain([(format!("{}.svg", m.name), m.chart.to_svg())]) {
            if let Some(file) = files.remove(&name) {
                set.add(file, move |to| Ok(to.write_all(text.as_bytes())?));
            }
        }
    }
    let kept = set.write(&Rescue::beside(&args.scene, common.root.as_ref()));
    printed?;
    Ok(if kept == Kept::InPlace { ExitStatus::Done } else { ExitStatus::Fault })
}

/// The names of the files that a benchmark writes.
fn file_names(wanted: impl Fn(&str) -> bool) -> impl Iterator<Item = String> {
    let measured = [
        ("integrators", "camera_rays", Some("camera_rays_at_equal_error")),
        ("integrators", "bounce_rays", Some("bounce_rays_at_equal_error")),
        ("transports", "transports", None),
    ];
    measured.into_iter().filter(move |(what, ..)| wanted(what)).flat_map(|(_, name, summary)| {
        [Some(format!("{name}.csv")), summary.map(|s| format!("{s}.csv")), Some(format!("{name}.svg"))].into_iter().flatten()
    })
}
