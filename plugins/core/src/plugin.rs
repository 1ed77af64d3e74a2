//! A plugin: a name, a sentence, and a constructor that reads its parameters.

use crate::params::Params;

/// One entry of a crate's explicit list `ALL`.
///
/// `T` is the trait of the kind, such as `dyn Material`. The constructor asks for all of its parameters before it gives up
/// on anything, so that its parameter table is complete; it returns `None` only after it has reported why, or if a required
/// parameter is absent.
pub struct Plugin<T: ?Sized> {
    /// The name that scenes use.
    pub name: &'static str,
    /// One sentence for `bhs plugins`.
    pub summary: &'static str,
    /// The constructor.
    pub build: fn(&Params) -> Option<Box<T>>,
}

impl<T: ?Sized> Clone for Plugin<T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: ?Sized> Copy for Plugin<T> {}

/// Defines the test that every file of a plugin crate's `src` folder stands in its list: one plugin a file, `_` written as
/// `-`; `lib.rs` and the named helper files are no plugins.
///
/// ```ignore
/// bhs_core::every_file_is_listed!([ALL], helpers: ["microfacet"]);
/// ```
#[macro_export]
macro_rules! every_file_is_listed {
    ([$($list:expr),+], helpers: [$($helper:literal),*]) => {
        #[test]
        fn every_file_is_listed() {
            let helpers: &[&str] = &["lib", $($helper),*];
            let mut files: Vec<String> = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/src"))
                .expect("the crate's src folder can be read")
                .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
                .filter_map(|file| file.strip_suffix(".rs").map(str::to_owned))
                .filter(|name| !helpers.contains(&name.as_str()))
                .map(|name| name.replace('_', "-"))
                .collect();
            files.sort();
            let mut listed: Vec<String> = Vec::new();
            $(listed.extend($list.iter().map(|p| p.name.to_owned()));)+
            listed.sort();
            assert_eq!(files, listed, "each file in src/ is one plugin, listed in ALL");
        }
    };
}
