//! A scene file as a generic tree: objects with a plugin type, an id and named properties.
//!
//! Nothing here knows what a plugin means; that is the business of [`super::Scene::load`].

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::error::{Place, SceneError};
use super::files::find_file;
use super::spectrum::{Purpose, Spectrum};

/// The most warnings that are kept.
const MOST_WARNINGS: usize = 100;

/// Index of an object in its [`Document`].
pub type ObjectId = usize;

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `<float>`
    Float(f64),
    /// `<integer>`
    Integer(i64),
    /// `<boolean>`
    Boolean(bool),
    /// `<string>`
    String(String),
    /// `<rgb>`: linear Rec. 709.
    Rgb(DVec3),
    /// `<spectrum>`
    Spectrum(Spectrum),
    /// `<vector>` or `<point>`
    Vector(DVec3),
    /// `<transform>`: all its operations composed.
    Transform(DMat4),
    /// A nested object, or one that `<ref>` names.
    Object(ObjectId),
}

impl Value {
    /// The tag that writes such a value.
    pub fn tag(&self) -> &'static str {
        match self {
            Self::Float(_) => "float",
            Self::Integer(_) => "integer",
            Self::Boolean(_) => "boolean",
            Self::String(_) => "string",
            Self::Rgb(_) => "rgb",
            Self::Spectrum(_) => "spectrum",
            Self::Vector(_) => "vector",
            Self::Transform(_) => "transform",
            Self::Object(_) => "object",
        }
    }
}

/// A property of an object.
#[derive(Clone, Debug)]
pub struct Property {
    /// The name; empty for nested objects and references that have none.
    pub name: String,
    /// The value.
    pub value: Value,
    /// Where it is written.
    pub place: Place,
}

/// An object of the scene: a shape, a material, a sensor.
#[derive(Clone, Debug)]
pub struct Object {
    /// The tag, for example `bsdf`.
    pub tag: String,
    /// The plugin type, for example `diffuse`; empty for the scene itself.
    pub plugin: String,
    /// The id that references name.
    pub id: Option<String>,
    /// The properties in file order.
    pub properties: Vec<Property>,
    /// Where it is written.
    pub place: Place,
    /// The folders in which its files are looked up, first match wins.
    pub folders: Rc<Vec<PathBuf>>,
    /// Whether its file is of a version before 2, whose renderer only warned of what it did not know.
    pub old: bool,
}

/// A whole scene file with its includes; the root is object 0 and references are resolved.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// All objects, parents before their nested objects.
    pub objects: Vec<Object>,
    /// Objects by id.
    pub ids: HashMap<String, ObjectId>,
    /// What is strange about the file but no reason not to render it.
    pub warnings: RefCell<Vec<SceneError>>,
    /// The files that have been read, in this order.
    pub files: RefCell<Vec<PathBuf>>,
    /// The parameters from outside that say nothing but how many samples there are.
    pub sample_parameters: Vec<String>,
}

impl Document {
    /// References may form no circle, so that whoever follows them comes to an end.
    pub fn reject_cycles(&self) -> Result<(), SceneError> {
        #[derive(Clone, Copy, PartialEq)]
        enum State {
            New,
            Open,
            Done,
        }
        let mut states = vec![State::New; self.objects.len()];
        let mut stack = vec![(0, 0)];
        while let Some((object, next)) = stack.pop() {
            states[object] = State::Open;
            let Some(property) = self.objects[object].properties.get(next) else {
                states[object] = State::Done;
                continue;
            };
            stack.push((object, next + 1));
            if let Value::Object(child) = property.value {
                match states[child] {
                    State::New => stack.push((child, 0)),
                    State::Open => {
                        return Err(property.place.error("this reference closes a circle"));
                    }
                    State::Done => {}
                }
            }
        }
        Ok(())
    }

    /// Notes a warning; a file that gives thousands of them is not worth more memory.
    pub fn warn(&self, warning: SceneError) {
        let mut warnings = self.warnings.borrow_mut();
        if warnings.len() < MOST_WARNINGS {
            warnings.push(warning);
        }
    }

    /// Reads the properties of an object, keeping track of which were asked for.
    pub fn query(&self, id: ObjectId) -> Query<'_> {
        Query { document: self, object: &self.objects[id], known: RefCell::default() }
    }
}

/// Typed access to the properties of one object. Call [`Query::finish`] at the end: it reports
/// properties that nobody asked for.
pub struct Query<'a> {
    document: &'a Document,
    /// The object.
    pub object: &'a Object,
    known: RefCell<Vec<&'static str>>,
}

impl<'a> Query<'a> {
    /// The property of that name.
    pub fn get(&self, name: &'static str) -> Option<&'a Property> {
        self.known.borrow_mut().push(name);
        self.object.properties.iter().find(|p| p.name == name)
    }

    fn typed<T>(
        &self,
        name: &'static str,
        expected: &str,
        convert: impl Fn(&Value) -> Option<T>,
    ) -> Result<Option<T>, SceneError> {
        let Some(property) = self.get(name) else {
            return Ok(None);
        };
        convert(&property.value).map(Some).ok_or_else(|| {
            property.place.error(format!(
                "\"{name}\" is a <{}>, but must be a <{expected}>",
                property.value.tag()
            ))
        })
    }

    /// A real number; integers are taken too.
    pub fn float(&self, name: &'static str) -> Result<Option<f64>, SceneError> {
        self.typed(name, "float", |value| match value {
            Value::Float(x) => Some(*x),
            Value::Integer(x) => Some(*x as f64),
            _ => None,
        })
    }

    /// An integer in `min..=max`.
    pub fn integer(
        &self,
        name: &'static str,
        min: i64,
        max: i64,
    ) -> Result<Option<i64>, SceneError> {
        let found = self.typed(name, "integer", |value| match value {
            Value::Integer(x) => Some(*x),
            _ => None,
        })?;
        match found {
            Some(x) if x < min || x > max => {
                Err(self.error_at(name, format!("\"{name}\" is {x}, but must be in {min}..={max}")))
            }
            other => Ok(other),
        }
    }

    /// A truth value.
    pub fn boolean(&self, name: &'static str) -> Result<Option<bool>, SceneError> {
        self.typed(name, "boolean", |value| match value {
            Value::Boolean(x) => Some(*x),
            _ => None,
        })
    }

    /// The file that the property "filename" names, which is noted as one that is read.
    pub fn file(&self) -> Result<PathBuf, SceneError> {
        let name = self.string("filename")?;
        let name = name.ok_or_else(|| self.error_at("", "the string \"filename\" is missing"))?;
        let path = find_file(name, &self.object.folders);
        let path = path.map_err(|error| self.error_at("filename", error))?;
        self.document.files.borrow_mut().push(path.clone());
        Ok(path)
    }

    /// A text.
    pub fn string(&self, name: &'static str) -> Result<Option<&'a str>, SceneError> {
        let Some(property) = self.get(name) else {
            return Ok(None);
        };
        match &property.value {
            Value::String(text) => Ok(Some(text)),
            other => Err(property
                .place
                .error(format!("\"{name}\" is a <{}>, but must be a <string>", other.tag()))),
        }
    }

    /// A point or vector.
    pub fn vector(&self, name: &'static str) -> Result<Option<DVec3>, SceneError> {
        self.typed(name, "point", |value| match value {
            Value::Vector(x) => Some(*x),
            _ => None,
        })
    }

    /// A transform.
    pub fn transform(&self, name: &'static str) -> Result<Option<DMat4>, SceneError> {
        self.typed(name, "transform", |value| match value {
            Value::Transform(x) => Some(*x),
            _ => None,
        })
    }

    /// A colour: `<rgb>`, `<spectrum>` or a `<float>`, which is grey.
    pub fn color(&self, name: &'static str, purpose: Purpose) -> Result<Option<DVec3>, SceneError> {
        self.typed(name, "rgb", |value| match value {
            Value::Rgb(x) => Some(*x),
            Value::Spectrum(spectrum) => Some(spectrum.colour(purpose)),
            Value::Float(x) => Some(DVec3::splat(*x)),
            Value::Integer(x) => Some(DVec3::splat(*x as f64)),
            _ => None,
        })
    }

    /// The nested or referenced objects, in file order, whatever their names.
    pub fn children(&self) -> impl Iterator<Item = (&'a Property, ObjectId)> + use<'a> {
        self.object.properties.iter().filter_map(|p| match p.value {
            Value::Object(id) => Some((p, id)),
            _ => None,
        })
    }

    /// The one nested object with that tag, or an error if there are several.
    pub fn child(&self, tag: &str) -> Result<Option<ObjectId>, SceneError> {
        let mut found = None;
        for (property, id) in self.children() {
            if self.document.objects[id].tag == tag {
                if found.is_some() {
                    return Err(property
                        .place
                        .error(format!("a second <{tag}>; only one is allowed here")));
                }
                found = Some(id);
            }
        }
        Ok(found)
    }

    /// Accepts properties that make no difference here.
    pub fn ignore(&self, names: &[&'static str]) {
        self.known.borrow_mut().extend(names);
    }

    /// Rejects values of unknown name and nested objects whose tag is not listed.
    pub fn finish(&self, tags: &[&str]) -> Result<(), SceneError> {
        let known = self.known.borrow();
        for property in &self.object.properties {
            if let Value::Object(id) = property.value {
                let child = &self.document.objects[id];
                if !tags.contains(&child.tag.as_str()) {
                    let supported = tags.iter().map(|tag| format!("<{tag}>"));
                    return Err(property.place.error(format!(
                        "<{}> is not supported inside {}; supported: {}",
                        child.tag,
                        self.object.place.element,
                        list(supported)
                    )));
                }
            } else if !known.contains(&property.name.as_str()) {
                let error = property.place.error(format!(
                    "unreferenced property \"{}\" in {}; supported: {}",
                    property.name,
                    self.object.place.element,
                    list(known.iter().map(|name| (*name).to_owned()))
                ));
                if !self.object.old {
                    return Err(error);
                }
                self.document.warn(error);
            }
        }
        Ok(())
    }

    /// An error at a property, or at the object if it has no such property.
    pub fn error_at(&self, name: &str, message: impl Into<String>) -> SceneError {
        // There are nameless properties too: what an object is made of.
        let is_named = |p: &&Property| !name.is_empty() && p.name == name;
        let property = self.object.properties.iter().find(is_named);
        property
            .map_or_else(|| self.object.place.error(""), |property| property.place.error(""))
            .with_message(message)
    }

    /// The position of something, which a property says, if it is not so far away that single precision has no room for what
    /// depends on it.
    pub fn near_enough(
        &self,
        what: &str,
        (name, position): (&str, DVec3),
    ) -> Result<DVec3, SceneError> {
        if position.abs().max_element() <= 1e15 {
            return Ok(position);
        }
        Err(self.error_at(name, format!("the {what} is too far away; scale the scene")))
    }

    /// The error for a plugin that does not exist here.
    pub fn unsupported(&self, supported: &str) -> SceneError {
        let place = &self.object.place;
        place.error(format!("not supported; supported: {supported}"))
    }
}

impl SceneError {
    fn with_message(mut self, message: impl Into<String>) -> Self {
        self.message = message.into();
        self
    }
}

fn list(names: impl Iterator<Item = String>) -> String {
    let names: Vec<String> = names.collect();
    if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
}
