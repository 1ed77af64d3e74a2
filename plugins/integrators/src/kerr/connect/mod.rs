//! Which light rays join two points around a hole that spins.
//!
//! Two are offered: the direct one, before any neighbours of it meet again, and the one round the other side, whose neighbours have met once. Inside
//! the thin tube behind the hole where four meet, and of light that winds further, the others are left to BSDF sampling.
//!
//! `search` has what is looked for, and begins with the rays of the hole without spin; `edge` is the edge of capture; `bundle` has rays with their
//! neighbours (`pencil`), `series` follows them. `quick` makes most of them end where they are to end, eight side by side (`packet`); `newton` those
//! that are left, where `reached` says where they have come.

pub mod bundle;
pub mod edge;
pub mod newton;
pub mod packet;
pub mod pencil;
pub mod quick;
pub mod reached;
pub mod search;
pub mod series;

use crate::kerr::connect::bundle::Spin;
use crate::kerr::connect::newton::{Found, run_all, sharpened};
use crate::kerr::connect::quick::run_side_by_side;
use crate::kerr::connect::reached::{Trial, follow_all};
use crate::kerr::connect::search::{Guess, Image, Search, Target, all_without_spin};
use arrayvec::ArrayVec;
use bhs_core::lanes::LANES;
use bhs_elementary::Elementary;
use bhs_engine::connections::ConnectionPair;
use glam::DVec3;

/// How far from its end a ray that was traced may be, over the distance between the ends, and surely, or maybe, be the ray that was found; and how
/// far apart two that were found may be and be one.
const SURELY: f64 = 1e-3;
const MAYBE: f64 = 0.3;
const ONCE: f64 = 0.01;

/// Cosine of the largest angle between launches of one and the same ray.
const SAME_LAUNCH: f64 = 0.95;

/// The rays between each of `pairs`, of both those that `choose` asks for, which is told their number and both rays around the hole without spin.
pub fn find_all(
    spin: Spin<f64>,
    pairs: &[(DVec3, Target)],
    mut choose: impl FnMut(usize, &ConnectionPair) -> [bool; 2],
) -> Vec<[Option<Found>; 2]> {
    let mut searches: Vec<Search> = Vec::with_capacity(2 * pairs.len());
    let mut places: Vec<(usize, usize)> = Vec::with_capacity(2 * pairs.len());
    for (k, ((x, to), plain)) in pairs.iter().zip(all_without_spin(pairs)).enumerate() {
        let (both, outlines) =
            if *to == Target::Point(*x) { ([None; 2], [None; 2]) } else { Search::both(spin.a, (*x, *to), plain) };
        let chosen = choose(k, &outlines);
        for (image, search) in both.into_iter().enumerate().filter(|(image, _)| chosen[*image]) {
            searches.extend(search);
            places.extend(search.map(|_| (k, image)));
        }
    }
    let mut found = vec![[None; 2]; pairs.len()];
    for ((k, image), ray) in places.into_iter().zip(search_all(spin, &searches)) {
        found[k][image] = ray;
    }
    found
}

/// Angles (rad) by which launches are turned aside to begin with where a search had no success.
const ASIDE: [f64; 4] = [0.5, -0.5, 1.0, -1.0];

/// What is found of `searches`.
fn search_all(spin: Spin<f64>, searches: &[Search]) -> Vec<Option<Found>> {
    let mut found = vec![None; searches.len()];
    complete(&mut found, searches, |search| Some(*search), |searches| side_by_side(spin, searches));
    complete(&mut found, searches, Search::other_way, |searches| side_by_side(spin, searches));
    complete(&mut found, searches, |search| Some(*search), |searches| run_all(spin, searches));
    for by in ASIDE {
        complete(&mut found, searches, |search| search.from_aside(by), |searches| side_by_side(spin, searches));
    }
    complete(&mut found, searches, Search::other_way, |searches| run_all(spin, searches));
    found
}

/// Looks for those of `searches` that are not `found` yet, as `other` would have them begin.
fn complete(
    found: &mut [Option<Found>],
    searches: &[Search],
    other: impl Fn(&Search) -> Option<Search>,
    run: impl FnOnce(&[Search]) -> Vec<Option<Found>>,
) {
    let left = searches.iter().enumerate().filter(|(i, _)| found[*i].is_none());
    let (places, again): (Vec<usize>, Vec<Search>) = left.filter_map(|(i, search)| Some((i, other(search)?))).unzip();
    if again.is_empty() {
        return;
    }
    for (i, ray) in places.into_iter().zip(run(&again)) {
        found[i] = ray;
    }
}

/// What is found of `searches`, those for the same image side by side.
fn side_by_side(spin: Spin<f64>, searches: &[Search]) -> Vec<Option<Found>> {
    let mut found = vec![None; searches.len()];
    for image in [Image::Direct, Image::Round] {
        let of_image: Vec<usize> = (0..searches.len()).filter(|i| searches[*i].image == image).collect();
        for numbers in of_image.chunks(LANES) {
            let packet: ArrayVec<&Search, LANES> = numbers.iter().map(|i| &searches[*i]).collect();
            for (i, ray) in numbers.iter().zip(run_side_by_side(spin, image, &packet)) {
                found[*i] = ray;
            }
        }
    }
    found
}

/// The ray that [`find_all`] finds from `x` to `target` and that `traced`, which strays a little, is.
pub fn image_of(spin: Spin<f64>, x: DVec3, target: Target, traced: Guess) -> Option<Found> {
    if target == Target::Point(x) {
        return None;
    }
    let e1 = traced.launch.any_orthonormal_vector();
    let trial = Trial { a: spin.a, x, guess: traced, aside: [e1, traced.launch.cross(e1)], exit: f64::NEG_INFINITY };
    // Neighbours say which of the two it can be.
    let image =
        if follow_all(spin.charge_squared, &[trial], false)[0]?.determinant() > 0.0 { Image::Direct } else { Image::Round };
    let ends = (x, target);
    let search =
        Search::both(spin.a, ends, all_without_spin(&[ends])[0]).0.into_iter().flatten().find(|search| search.image == image)?;
    let found = search_all(spin, &[search])[0]?;
    let is_it = found.is_same(traced, SURELY)
        || (found.is_same(traced, MAYBE)
            && sharpened(spin, &search, traced).is_some_and(|exact| found.is_same(exact.guess, ONCE)));
    is_it.then_some(found)
}

impl Found {
    /// Whether the ray `other` is this one: if it has about the same launch, and as a neighbour would end no further off than `within`, over the
    /// distance between the ends.
    fn is_same(&self, other: Guess, within: f64) -> bool {
        let [a, b] = self.end.aside.map(|aside| aside.dot(other.launch - self.guess.launch));
        let (aside, rise) = self.end.moved(DVec3::new(a, b, other.tau - self.guess.tau));
        let off = aside.length().hypotenuse(rise * self.scale.0) * self.scale.1;
        self.guess.launch.dot(other.launch) > SAME_LAUNCH && off <= within
    }
}
