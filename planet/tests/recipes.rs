//! Recipes: the shipped ones parse, and each kind of mistake is refused with file, line, key path, found and expected.

#![allow(clippy::unwrap_used, reason = "a failed unwrap is a failed test")]

use std::path::{Path, PathBuf};
use terrane_planet::recipe::{Asset, Layer, Recipe, RecipeError};

const HEAD: &str = "name = \"T\"\nradius_m = 10000.0\nseed = 1\n";
const PALETTE: &str = "[palette]\nkind = \"airless\"\nhighland = [1, 2, 3]\nmare = [1, 2, 3]\nray = [1, 2, 3]\n\
                       mare_m = [0, 1]\npatch_m = 500\n";

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recipes").join(name)
}

fn parse(text: &str) -> Result<Recipe, RecipeError> {
    Recipe::from_toml(text, "t.toml", Path::new("."))
}

fn with_layer(layer: &str) -> String {
    format!("{HEAD}[[layer]]\n{layer}\n{PALETTE}")
}

/// The message of a recipe that must be refused.
fn refusal(text: &str) -> String {
    parse(text).expect_err("this recipe should be refused").to_string()
}

#[track_caller]
fn assert_refused(text: &str, parts: &[&str]) {
    let message = refusal(text);
    for part in parts {
        assert!(message.contains(part), "{message:?} lacks {part:?}");
    }
}

#[test]
fn shipped_recipes_parse() {
    for name in ["terra.toml", "luna.toml", "mars.toml", "tiny.toml"] {
        let recipe = Recipe::load(&shipped(name)).unwrap_or_else(|e| panic!("{e}"));
        assert!(!recipe.layers.is_empty() && recipe.assets.is_empty());
        let again = Recipe::from_parts(&recipe.text, &recipe.name, recipe.assets.clone()).unwrap();
        assert_eq!(again.text, recipe.text);
    }
    let terra = Recipe::load(&shipped("terra.toml")).unwrap();
    assert_eq!((terra.radius, terra.sea.unwrap().level_m), (6_371_000.0, 0.0));
    assert!(terra.atmosphere.unwrap().rayleigh[2] > 3e-5);
}

#[test]
fn every_recipe_of_the_folder_is_shipped_under_its_name() {
    let files = std::fs::read_dir(shipped("")).unwrap().map(|entry| entry.unwrap().path());
    let mut in_folder: Vec<String> = files
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    let mut names: Vec<&str> = terrane_planet::recipe::shipped::names().collect();
    in_folder.sort_unstable();
    names.sort_unstable();
    assert_eq!(names, in_folder);
    for name in names {
        let (found, file) =
            (terrane_planet::recipe::shipped::load(name).unwrap(), Recipe::load(&shipped(&format!("{name}.toml"))).unwrap());
        assert!(found.text == file.text && found.assets == file.assets, "{name} differs from its file");
    }
    let message = terrane_planet::recipe::shipped::load("terra.toml").unwrap_err().to_string();
    assert!(message.contains("terra.toml") && message.contains("terra, luna, mars"), "{message}");
}

#[test]
fn a_minimal_recipe_is_read() {
    let recipe = parse(&with_layer("kind = \"plains\"\nwavelength_m = 50\ngain = 0.5\namplitude_m = 3")).unwrap();
    assert!(matches!(&recipe.layers[0], Layer::Plains(p) if p.octaves.detail_m == 1.0));
}

#[test]
fn a_missing_file_is_named() {
    let message = Recipe::load(Path::new("/no/such.toml")).unwrap_err().to_string();
    assert!(message.contains("/no/such.toml"), "{message}");
}

#[test]
fn broken_toml_is_refused_with_its_line() {
    assert_refused("name = \"T\"\nradius_m = = 3\n", &["t.toml:2", "not valid TOML"]);
}

#[test]
fn unknown_keys_are_refused() {
    let parts = ["t.toml:4", "`colour`", "unknown key", "radius_m"];
    assert_refused(&format!("{HEAD}colour = 3\n{PALETTE}"), &parts);
    let layer = "kind = \"plains\"\nwavelength_m = 50\ngain = 0.5\namplitude_m = 3\nheight = 2";
    assert_refused(&with_layer(layer), &["t.toml:9", "`layer[0].height`", "unknown key", "amplitude_m"]);
    let sea = format!("{HEAD}[sea]\nlevel_m = 0\nshallow = [0,0,0]\ndeep = [0,0,0]\nsalt = 3\n{PALETTE}");
    assert_refused(&sea, &["t.toml:8", "`sea.salt`"]);
    assert_refused(&format!("{HEAD}{PALETTE}moss = [1,2,3]\n"), &["t.toml:11", "`palette.moss`", "unknown"]);
}

#[test]
fn missing_keys_are_refused() {
    assert_refused("name = \"T\"\nseed = 1\n", &["`radius_m`", "found nothing", "a number from 1000 to 100000000"]);
    assert_refused(HEAD, &["`palette`", "found nothing", "a table"]);
    assert_refused(&with_layer("wavelength_m = 3"), &["t.toml:4", "`layer[0].kind`", "found nothing"]);
}

#[test]
fn wrong_types_are_refused() {
    let text = HEAD.replace("10000.0", "\"big\"");
    assert_refused(&text, &["t.toml:2", "`radius_m`", "string \"big\"", "a number from 1000"]);
    assert_refused(&HEAD.replace("seed = 1", "seed = 1.5"), &["t.toml:3", "`seed`", "float 1.5", "whole number"]);
    assert_refused(&HEAD.replace("seed = 1", "seed = -1"), &["t.toml:3", "`seed`", "integer -1"]);
    assert_refused(&HEAD.replace("\"T\"", "7"), &["t.toml:1", "`name`", "integer 7"]);
    assert_refused(&format!("{HEAD}sea = 3\n{PALETTE}"), &["t.toml:4", "`sea`", "integer 3", "a table"]);
    assert_refused(&format!("{HEAD}layer = 3\n{PALETTE}"), &["t.toml:4", "`layer`", "array of tables"]);
    let craters = "kind = \"craters\"\nlargest_m = 500\nsmallest_m = 10\nbasins = 1";
    assert_refused(&with_layer(craters), &["t.toml:8", "`layer[0].basins`", "true or false"]);
}

#[test]
fn values_out_of_range_are_refused() {
    assert_refused(&HEAD.replace("10000.0", "5"), &["t.toml:2", "`radius_m`", "integer 5", "from 1000"]);
    assert_refused(&HEAD.replace("10000.0", "nan"), &["t.toml:2", "`radius_m`", "nan"]);
    let plains = "kind = \"plains\"\nwavelength_m = 50\ngain = 1.5\namplitude_m = 3";
    assert_refused(&with_layer(plains), &["t.toml:7", "`layer[0].gain`", "float 1.5", "from 0.2 to 0.8"]);
    let craters = "kind = \"craters\"\nlargest_m = 9000\nsmallest_m = 10";
    assert_refused(&with_layer(craters), &["t.toml:6", "`layer[0].largest_m`", "9000", "to 3500"]);
    let profile = "kind = \"continents\"\nwavelength_m = 50\ngain = 0.5\nprofile = [[0, 0], [0.1, -5]]";
    assert_refused(&with_layer(profile), &["t.toml:8", "`layer[0].profile`", "rising"]);
    let sea = format!("{HEAD}[sea]\nshallow = [0, 0]\ndeep = [0,0,0]\n{PALETTE}");
    assert_refused(&sea, &["t.toml:5", "`sea.shallow`", "3 values"]);
    assert_refused(&format!("{HEAD}{PALETTE}").replace("[0, 1]", "[1, 0]"), &["`palette.mare_m`", "first below"]);
    assert_refused(&with_layer("kind = \"moss\""), &["t.toml:5", "`layer[0].kind`", "\"moss\"", "plains"]);
}

#[test]
fn wrong_landforms_and_deserts_are_refused() {
    let canyons = "kind = \"canyons\"\nwavelength_m = 50\ngain = 0.5\ndepth_m = 3\nwidth = 0.3\nregion_m = 500";
    parse(&with_layer(canyons)).unwrap();
    assert_refused(
        &with_layer(&canyons.replace("0.3", "1.5")),
        &["t.toml:9", "`layer[0].width`", "float 1.5", "from 0.02 to 0.9"],
    );
    assert_refused(&with_layer(&canyons.replace("depth_m = 3\n", "")), &["`layer[0].depth_m`", "found nothing"]);
    assert_refused(&with_layer(&format!("{canyons}\nroundness = 1")), &["`layer[0].roundness`", "unknown key", "ledges"]);
    let dunes = "kind = \"dunes\"\nwavelength_m = 50\namplitude_m = 3\nregion_m = 500";
    parse(&with_layer(dunes)).unwrap();
    assert_refused(&with_layer(&dunes.replace("= 50\n", "= 0\n")), &["t.toml:6", "`layer[0].wavelength_m`", "integer 0"]);
    assert_refused(&with_layer(&format!("{dunes}\ngain = 0.5")), &["`layer[0].gain`", "unknown key", "cover"]);
    let craters = "kind = \"craters\"\nlargest_m = 500\nsmallest_m = 10\nwarp_m = 200";
    assert_refused(&with_layer(craters), &["t.toml:8", "`layer[0].warp_m`", "integer 200", "to 125"]);
    let continents = "kind = \"continents\"\nwavelength_m = 50\ngain = 0.5\nprofile = [[0, 0], [1, 5]]\nnorth = 3";
    assert_refused(&with_layer(continents), &["`layer[0].north`", "integer 3", "from -2 to 2"]);
    let shield = "kind = \"shield\"\nlatitude_deg = 3\nlongitude_deg = 4\nradius_m = 500\nheight_m = 90\ncaldera_m = 100";
    parse(&with_layer(shield)).unwrap();
    assert_refused(&with_layer(&shield.replace("= 100", "= 300")), &["`layer[0].caldera_m`", "integer 300", "to 250"]);
    let rift = "kind = \"rift\"\nlatitude_deg = 3\nlongitude_deg = 4\nheading_deg = 5\nlength_m = 900\nwidth_m = 90\ndepth_m = 9";
    parse(&with_layer(rift)).unwrap();
    assert_refused(&with_layer(&rift.replace("= 90\n", "= 500\n")), &["`layer[0].width_m`", "integer 500", "to 450"]);
    let caps = "kind = \"caps\"\nlatitude_deg = 80\nheight_m = 90";
    parse(&with_layer(caps)).unwrap();
    assert_refused(&with_layer(&caps.replace("80", "90")), &["`layer[0].latitude_deg`", "integer 90", "to 89"]);
    parse(&with_layer("kind = \"lava\"\nlevel_m = -80")).unwrap();
    let desert = "[palette]\nkind = \"desert\"\ndust = [1, 2, 3]\nsand = [1, 2, 3]\ndune = [1, 2, 3]\nrock = [1, 2, 3]\n\
                  strata = [1, 2, 3]\nice = [1, 2, 3]\nice_deg = 80\nrock_slope = [0, 1]\nclimate_m = 500\npatch_m = 500\n";
    parse(&format!("{HEAD}{desert}")).unwrap();
    assert_refused(&format!("{HEAD}{}", desert.replace("= 80", "= 0")), &["`palette.ice_deg`", "integer 0", "from 1 to 90"]);
    assert_refused(&format!("{HEAD}{desert}snow = [1, 2, 3]\n"), &["`palette.snow`", "unknown key", "sand_cover"]);
}

#[test]
fn a_missing_heightmap_is_named() {
    let layer = with_layer("kind = \"heightmap\"\nfile = \"gone.png\"\nrange_m = [0, 100]");
    assert_refused(&layer, &["t.toml:6", "`layer[0].file`", "gone.png", "readable file"]);
    let bytes = vec![1, 2];
    let other = vec![Asset { name: "other.png".into(), bytes }];
    let message = Recipe::from_parts(&layer, "t.toml", other).unwrap_err().to_string();
    assert!(message.contains("gone.png") && message.contains("assets"), "{message}");
}
