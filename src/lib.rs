//! bhs renders scenes with a black hole in them: triangle meshes of any size, area lights, diffuse and specular materials,
//! measured spectra, full global illumination, all of it lit and seen along curved light.
//!
//! The library is what the program `bhs` is made of: [`lang::load`] turns a scene file into a [`lang::BuiltScene`],
//! [`render`] turns that into a picture. What plugins see is the crate `bhs-core`, what follows light
//! `bhs-engine` too; ARCHITECTURE.md says where things are.

pub mod adaptive;
pub mod advice;
pub mod animation;
pub mod bench;
pub mod bloom;
pub mod checkpoint;
pub mod cli;
pub mod colour_map;
pub mod commands;
pub mod compare;
pub mod denoise;
pub mod develop;
pub mod diagnosis;
pub mod difference;
pub mod display;
pub mod false_color;
pub mod files;
pub mod film;
pub mod finished;
pub mod flip;
pub mod glossary;
pub mod header;
pub mod image;
pub mod job;
pub mod lang;
pub mod layers;
pub mod loading;
pub mod look;
pub mod memory;
pub mod message;
pub mod not_finite;
pub mod output;
pub mod parts;
pub mod patches;
pub mod plot;
pub mod plugins_table;
pub mod point_picture;
pub mod program;
pub mod progress;
pub mod registry;
pub mod render;
pub mod replay;
pub mod report;
pub mod sample;
pub mod signals;
pub mod sky_points;
pub mod stats;
pub mod threads;
pub mod ticker;
pub mod trace;
pub mod vectors;
pub mod watch;
pub mod wavelengths;
