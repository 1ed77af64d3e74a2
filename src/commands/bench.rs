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
    if args.scenes.iter().any(|scene| scene == Path::new("-")) {
        // It is read several times.
        say!("error: `bhs bench` needs a file");
        return Ok(ExitStatus::CommandLine);
    }
    let names: Vec<_> = args.scenes.iter().map(|scene| scene.file_stem().unwrap_or_default()).collect();
    if let Some(name) = names.iter().enumerate().find(|(i, name)| args.output.is_some() && names[..*i].contains(name)) {
        say!("error: two of the scenes are called `{}`, and both would be written to the same folder", name.1.display());
        return Ok(ExitStatus::CommandLine);
    }
    let mut status = ExitStatus::Done;
    let mut texts = Vec::new();
    for (scene, name) in args.scenes.iter().zip(&names) {
        // One scene has the folder for itself.
        let folder = args.output.as_ref().map(|folder| if names.len() > 1 { folder.join(name) } else { folder.clone() });
        match bench_one(args, (scene, folder.as_deref()), common)? {
            Ok(text) => texts.push(text),
            Err(fault) => status = fault,
        }
    }
    let text = match (args.json, texts.len()) {
        (true, 1..) if names.len() > 1 => {
            let all: Vec<serde_json::Value> = texts.iter().map(|text| serde_json::from_str(text)).collect::<Result<_, _>>()?;
            serde_json::to_string_pretty(&all)? + "\n"
        }
        _ => texts.concat(),
    };
    print(&text)?;
    Ok(status)
}

/// Measures a scene and writes the files: what is printed of it, or why there is nothing.
fn bench_one(args: &BenchArgs, (scene, folder): (&Path, Option<&Path>), common: &Common) -> Result<Result<String, ExitStatus>> {
    let overrides = Overrides { variables: Variables::defined(&args.definitions.define), ..Default::default() };
    // Integrators at the scene's own resolution, which sets what they need not tell apart.
    let Some((built, sources)) = load(scene, &overrides, common) else { return Ok(Err(ExitStatus::Fault)) };
    let wanted = |what: &str| args.only.as_deref().is_none_or(|only| only == what);
    let mut files = BTreeMap::new();
    if let Some(folder) = folder {
        let mut plan = Plan::new(&sources);
        // In a folder that is not there yet, nothing can be in the way.
        let names: Vec<String> = if folder.exists() { file_names(wanted).collect() } else { Vec::new() };
        names.iter().for_each(|name| drop(plan.claim(&folder.join(name), NamedBy::CommandLine)));
        if let Err(found) = plan.finish() {
            show(&found, &sources, common.color);
            return Ok(Err(ExitStatus::Fault));
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
        let Some((small, _)) = load(scene, &overrides, common) else { return Ok(Err(ExitStatus::Fault)) };
        let registry = Registry::builtin();
        let make = |overrides: &Overrides| {
            let mut sources = common.sources();
            let overrides = Overrides { variables: variables.clone(), ..overrides.clone() };
            lang::load_method(scene, &registry, &overrides, &mut sources)
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
        if args.scenes.len() > 1 {
            text += &format!("# {}\n\n", scene.display());
        }
        for m in &measured {
            text += &format!("{}\n\n{}\n", m.chart.title, m.table.to_markdown());
            if let Some(summary) = &m.summary {
                text += &format!("{}, {}\n\n{}\n", m.name.replace('_', " "), summary.title, summary.table.to_markdown());
            }
        }
    }
    let mut set = OutputSet::new();
    for m in &measured {
        let tables = m.tables().map(|(name, table)| (format!("{name}.csv"), table.to_csv()));
        for (name, text) in tables.chain([(format!("{}.svg", m.name), m.chart.to_svg())]) {
            if let Some(file) = files.remove(&name) {
                set.add(file, move |to| Ok(to.write_all(text.as_bytes())?));
            }
        }
    }
    let kept = set.write(&Rescue::beside(scene, common.root.as_ref()));
    Ok(if kept == Kept::InPlace { Ok(text) } else { Err(ExitStatus::Fault) })
}

/// The names of the files that a benchmark writes.
fn file_names(wanted: impl Fn(&str) -> bool) -> impl Iterator<Item = String> {
    let measured = [
        ("integrators", "camera_rays", Some("camera_rays_at_equal_error")),
        ("integrators", "bounce_rays", Some("bounce_rays_at_equal_error")),
        ("transports", "transports", Some("transports_at_equal_error")),
    ];
    measured.into_iter().filter(move |(what, ..)| wanted(what)).flat_map(|(_, name, summary)| {
        [Some(format!("{name}.csv")), summary.map(|s| format!("{s}.csv")), Some(format!("{name}.svg"))].into_iter().flatten()
    })
}
