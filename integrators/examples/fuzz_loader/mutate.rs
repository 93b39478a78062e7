//! Damaged scenes: valid files with bytes, numbers and words changed, loaded as a scene would be.

use std::path::{Path, PathBuf};

use glam::Vec3;
use integrators::algorithm::Algorithm;
use integrators::kind;
use integrators::path::PathSettings;
use integrators::render::Splats;
use integrators::scene::{Scene, inspect};

/// A file that is valid until it is damaged.
pub struct Seed {
    /// Its name.
    pub name: String,
    bytes: Vec<u8>,
    /// The folder in which a scene names its files.
    folder: PathBuf,
}

/// What came of a damaged file.
#[derive(Debug, PartialEq)]
pub enum Outcome {
    /// It can still be rendered.
    Loaded,
    /// It is refused, with a message.
    Refused(String),
}

/// The valid files: scenes, meshes and pictures of a folder and those below it.
///
/// # Panics
/// If they cannot be read.
pub fn seeds(folder: &Path) -> Vec<Seed> {
    let mut seeds = Vec::new();
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            seeds.extend(self::seeds(&path));
        } else {
            let name = path.file_name().expect("a name").to_string_lossy().into_owned();
            let bytes = std::fs::read(&path).expect("a readable file");
            seeds.push(Seed { name, bytes, folder: folder.to_path_buf() });
        }
    }
    seeds
}

/// A reproducible stream of numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// What may be put in the place of a number or anywhere else.
/// The first of them are numbers, or were.
const NUMBERS: usize = 21;
const WORDS: [&str; 40] = [
    "nan",
    "inf",
    "-inf",
    "0",
    "-0",
    "-1",
    "1e999",
    "1e-999",
    "1e30",
    "1e-30",
    "1e15",
    "65536",
    "4294967295",
    "4294967296",
    "99999999999999999999",
    "0.5",
    "1",
    "2",
    "1 2 3",
    "#ff00ff",
    "$x",
    "\"",
    "<",
    ">",
    "/>",
    "&amp;",
    "\0",
    "\n",
    " ",
    "x",
    "shapegroup",
    "instance",
    "cylinder",
    "sphere",
    "thinlens",
    "orthographic",
    "twosided",
    "mask",
    "true",
    "<ref id=\"group\"/>",
];

/// Damages a file in one place or a few.
fn damaged(seed: &Seed, others: &[Seed], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.bytes.clone();
    let places = 1 + random.below(4) * random.below(3);
    for _ in 0..places {
        let at = random.below(bytes.len());
        let end = bytes.len().min(at + 1 + random.below(64));
        // Mostly numbers: few texts can be read at all once a character is lost.
        match random.below(25) {
            0 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            1 if at < bytes.len() => bytes[at] = [0, 0xff, 0x7f, 0x80, b'9'][random.below(5)],
            2 => drop(bytes.drain(at..end)),
            3 if random.below(4) == 0 => bytes.truncate(at),
            4 => {
                let copy = bytes[at..end].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, copy);
            }
            5 => {
                let other = &others[random.below(others.len())].bytes;
                let from = random.below(other.len());
                let piece = &other[from..other.len().min(from + 200)];
                bytes.splice(at..at, piece.iter().copied());
            }
            6 => {
                let word = WORDS[random.below(WORDS.len())];
                bytes.splice(at..at, word.bytes());
            }
            _ => {
                // The next number after a place.
                let is_digit = |b: &u8| b.is_ascii_digit() || b"+-.e".contains(b);
                let Some(first) = bytes[at..].iter().position(u8::is_ascii_digit) else { continue };
                let first = at + first;
                let length = bytes[first..].iter().take_while(|b| is_digit(b)).count();
                let word = WORDS[random.below(NUMBERS)];
                bytes.splice(first..first + length, word.bytes());
            }
        }
    }
    bytes
}

/// The damaged file number `case`, and the name that it had.
pub fn damaged_file(seeds: &[Seed], case: u64) -> (String, Vec<u8>) {
    let mut random = Random(case);
    let seed = &seeds[random.below(seeds.len())];
    (seed.name.clone(), damaged(seed, seeds, &mut random))
}

/// Loads the damaged file number `case`, and casts a few rays if it can be loaded. `scratch` is a
/// folder for it. Also tells which file it was.
///
/// # Panics
/// If the loader panics, or a ray meets what is not finite.
pub fn try_case(seeds: &[Seed], case: u64, scratch: &Path) -> (String, Outcome) {
    let mut random = Random(case);
    let seed = &seeds[random.below(seeds.len())];
    let bytes = damaged(seed, seeds, &mut random);
    let extension = seed.name.rsplit('.').next().unwrap_or("");
    let file = scratch.join(format!("damaged.{extension}"));
    let around = |inside: String| {
        format!("<scene version=\"3.0.0\"><sensor type=\"perspective\"/>{inside}</scene>")
    };
    let filename = format!("<string name=\"filename\" value=\"{}\"/>", file.display());
    let loaded = match extension {
        "xml" => Scene::from_str(&String::from_utf8_lossy(&bytes), &seed.folder, &[]),
        "obj" | "ply" | "serialized" => {
            std::fs::write(&file, &bytes).expect("a scratch file");
            let xml = around(format!("<shape type=\"{extension}\">{filename}</shape>"));
            Scene::from_str(&xml, scratch, &[])
        }
        _ => {
            std::fs::write(&file, &bytes).expect("a scratch file");
            let xml = around(format!(
                "<bsdf type=\"diffuse\"><texture type=\"bitmap\" name=\"reflectance\">{filename}\
                 </texture></bsdf>"
            ));
            Scene::from_str(&xml, scratch, &[])
        }
    };
    let outcome = match loaded {
        Ok(scene) => {
            look_around(&scene, &mut random);
            Outcome::Loaded
        }
        Err(error) => Outcome::Refused(error.to_string()),
    };
    (seed.name.clone(), outcome)
}

fn look_around(scene: &Scene, random: &mut Random) {
    // Paths of a few edges, whatever the file says: it may ask for endless ones.
    let settings = PathSettings { max_depth: Some(4), rr_depth: 3, ..PathSettings::new(scene) };
    let tracer = Algorithm::Path(settings)
        .kernel(kind::smallest(scene), scene, scene.sampler)
        .expect("a kind");
    let tracer = tracer.unwrap_or_else(|error| panic!("{error}"));
    let mut worker = tracer.worker();
    for _ in 0..4 {
        let x = random.below(scene.film.width as usize) as u32;
        let y = random.below(scene.film.height as usize) as u32;
        let value = worker((x, y), 0, &mut Splats::default());
        let least = if scene.film.filter.is_signed() { f32::MIN } else { 0.0 };
        assert!(value.iter().all(|v| v.is_finite() && *v >= least), "pixel {x}, {y}: {value:?}");
    }
    assert!(!inspect::json(scene).to_string().is_empty());
    for _ in 0..8 {
        let mut unit = || random.below(1 << 20) as f32 / (1 << 19) as f32 - 1.0;
        let direction = Vec3::new(unit(), unit(), unit());
        let Some(hit) = scene.intersect(scene.camera.origin, direction, None) else { continue };
        assert!(hit.position.is_finite() && hit.t.is_finite(), "{hit:?}");
        assert!((hit.geometric_normal.length() - 1.0).abs() < 1e-3, "{hit:?}");
        assert!((hit.shading_normal.length() - 1.0).abs() < 1e-3, "{hit:?}");
        assert!(scene.texture_coordinates(&hit).is_finite(), "{hit:?}");
    }
}
