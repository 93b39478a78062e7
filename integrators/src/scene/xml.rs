//! Reads Mitsuba 3 XML into a [`Document`].
//!
//! Includes are followed, parameters substituted, transforms composed and references resolved.

use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use roxmltree::Node;

use super::document::{Document, Object, ObjectId, Property, Value};
use super::error::{Place, SceneError, Source};
use super::files::{MOST_TEXT, find_file, read_text};
use super::params::Parameters;
use super::spectrum::Spectrum;
use super::transform::axes;
use super::upgrade::upgrade;
use super::values;

/// Tags that make an object.
const OBJECTS: [&str; 13] = [
    "scene",
    "sensor",
    "film",
    "rfilter",
    "sampler",
    "integrator",
    "shape",
    "bsdf",
    "emitter",
    "texture",
    "medium",
    "phase",
    "volume",
];
const MAX_INCLUDE_DEPTH: usize = 16;
const MAX_INCLUDES: usize = 1024;
const MAX_NESTING: usize = 32;

/// Reads a scene file. `defines` override the file's `<default>`s.
pub fn read_file(path: &Path, defines: &[(String, String)]) -> Result<Document, SceneError> {
    let text = read_text(path).map_err(|message| SceneError::in_file(path, message))?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    let document = read_str(&text, path, folder, defines)?;
    document.files.borrow_mut().insert(0, path.to_path_buf());
    Ok(document)
}

/// Reads a scene from a string; `path` names it in errors, files are looked up in `folder`.
pub fn read_str(
    text: &str,
    path: &Path,
    folder: PathBuf,
    defines: &[(String, String)],
) -> Result<Document, SceneError> {
    let mut reader = Reader {
        document: Document::default(),
        parameters: Parameters::new(defines),
        references: Vec::new(),
        includes: 0,
        included: 0,
    };
    let source = Arc::new(Source { path: path.to_path_buf(), text: text.to_owned() });
    reader.read(source, Rc::new(vec![folder]), None, 0)?;
    if let Some(name) = reader.parameters.unused() {
        return Err(SceneError::in_file(
            path,
            format!("-D {name}=…: the scene has no parameter ${name}"),
        ));
    }
    reader.document.sample_parameters = reader.parameters.counting_samples();
    reader.resolve_references()?;
    reader.document.objects.iter_mut().filter(|object| object.old).for_each(upgrade);
    reader.document.reject_cycles()?;
    Ok(reader.document)
}

/// A document being read.
pub(super) struct Reader {
    document: Document,
    parameters: Parameters,
    /// Object, index of its property, the id that it names.
    references: Vec<(ObjectId, usize, String)>,
    includes: usize,
    /// Bytes of included files.
    included: u64,
}

/// The file being read.
pub(super) struct Context {
    source: Arc<Source>,
    folders: Rc<Vec<PathBuf>>,
    /// How many includes deep.
    depth: usize,
    /// Whether the file is of a version before 2, in which names were written otherwise.
    old: bool,
}

/// Whether an element says how many samples a sampler has, by its name in any version.
fn is_sample_count(node: Node) -> bool {
    let is_sampler = |parent: Node| parent.tag_name().name() == "sampler";
    matches!(node.attribute("name"), Some("sample_count" | "sampleCount"))
        && node.parent_element().is_some_and(is_sampler)
}

pub(super) type Attributes<'a> = Vec<(&'a str, String)>;

pub(super) fn attribute<'a>(attributes: &'a Attributes, name: &str) -> Option<&'a str> {
    let found = attributes.iter().find(|(key, _)| *key == name);
    found.map(|(_, value)| value.as_str())
}

impl Reader {
    fn read(
        &mut self,
        source: Arc<Source>,
        folders: Rc<Vec<PathBuf>>,
        parent: Option<ObjectId>,
        depth: usize,
    ) -> Result<(), SceneError> {
        let xml = roxmltree::Document::parse(&source.text).map_err(|e| {
            let position = e.pos();
            let mut error = SceneError::in_file(&source.path, format!("not well-formed XML: {e}"));
            (error.line, error.column) = (Some(position.row), Some(position.col));
            error
        })?;
        let mut context = Context { source: source.clone(), folders, depth, old: false };
        let root = xml.root_element();
        let place = context.place(root);
        let Some(version) = root.attribute("version") else {
            return Err(place.error("the root element needs version=\"3.0.0\""));
        };
        let major = version.split('.').next().and_then(|major| major.trim().parse::<u32>().ok());
        match major {
            Some(major @ 0..=3) => context.old = major < 2,
            _ => {
                let message =
                    format!("version \"{version}\" is not supported; supported: 0.4 to 3");
                return Err(place.error(message));
            }
        }
        match parent {
            None if root.tag_name().name() != "scene" => {
                Err(place.error("the root element must be <scene>"))
            }
            // An included <scene> only brings its contents.
            Some(parent) if root.tag_name().name() == "scene" => {
                self.contents(&mut context, root, parent, 0)
            }
            _ => self.object(&mut context, root, parent, 0),
        }
    }

    fn contents(
        &mut self,
        context: &mut Context,
        node: Node,
        object: ObjectId,
        nesting: usize,
    ) -> Result<(), SceneError> {
        for child in node.children().filter(Node::is_element) {
            self.element(context, child, object, nesting)?;
        }
        Ok(())
    }

    fn element(
        &mut self,
        context: &mut Context,
        node: Node,
        parent: ObjectId,
        nesting: usize,
    ) -> Result<(), SceneError> {
        let tag = node.tag_name().name();
        if OBJECTS.contains(&tag) || (tag == "spectrum" && node.has_attribute("type")) {
            return self.object(context, node, Some(parent), nesting + 1);
        }
        let place = context.place(node);
        if tag != "transform" && node.children().any(|child| child.is_element()) {
            return Err(place.error("this element cannot have children"));
        }
        match tag {
            "default" => {
                let a = self.attributes(&place, node, &["name", "value"], &[])?;
                self.parameters.set_default(&a[0].1, &a[1].1).map_err(|e| place.error(e))
            }
            "include" => self.include(context, node, &place, parent),
            "path" => self.path(context, node, &place, parent),
            "alias" => self.alias(node, &place),
            "ref" => {
                let a = self.attributes(&place, node, &["id"], &["name"])?;
                let name = context.name(attribute(&a, "name").unwrap_or(""));
                let index = self.document.objects[parent].properties.len();
                self.references.push((parent, index, a[0].1.clone()));
                self.add(parent, name, Value::Object(parent), place)
            }
            "transform" => {
                let a = self.attributes(&place, node, &["name"], &[])?;
                let transform = self.transform(context, node)?;
                self.add(parent, context.name(&a[0].1), Value::Transform(transform), place)
            }
            _ => {
                let (name, value) = self.value(node, &place)?;
                self.add(parent, context.name(&name), value, place)
            }
        }
    }

    fn object(
        &mut self,
        context: &mut Context,
        node: Node,
        parent: Option<ObjectId>,
        nesting: usize,
    ) -> Result<(), SceneError> {
        let place = context.place(node);
        if nesting > MAX_NESTING {
            return Err(place.error("elements are nested too deeply"));
        }
        let tag = node.tag_name().name();
        let required: &[&str] = if tag == "scene" { &[] } else { &["type"] };
        let optional = ["id", "name", "version"];
        let a = self.attributes(&place, node, required, &optional)?;
        let id = self.document.objects.len();
        if let Some(name) = attribute(&a, "id") {
            self.name_object(name, id, &place)?;
        }
        self.document.objects.push(Object {
            tag: tag.to_owned(),
            plugin: attribute(&a, "type").unwrap_or("").to_owned(),
            id: attribute(&a, "id").map(str::to_owned),
            properties: Vec::new(),
            place: place.clone(),
            folders: context.folders.clone(),
            old: context.old,
        });
        if let Some(parent) = parent {
            let name = context.name(attribute(&a, "name").unwrap_or(""));
            self.add(parent, name, Value::Object(id), place)?;
        }
        self.contents(context, node, id, nesting)
    }

    fn name_object(&mut self, name: &str, id: ObjectId, place: &Place) -> Result<(), SceneError> {
        match self.document.ids.insert(name.to_owned(), id) {
            None => Ok(()),
            Some(_) => Err(place.error(format!("the id \"{name}\" is already in use"))),
        }
    }

    fn add(
        &mut self,
        object: ObjectId,
        name: String,
        value: Value,
        place: Place,
    ) -> Result<(), SceneError> {
        let Object { properties, old, .. } = &mut self.document.objects[object];
        let named = if name.is_empty() { &mut [] } else { &mut properties[..] };
        if let Some(before) = named.iter_mut().find(|p| p.name == name) {
            let error = place.error(format!("a second property named \"{name}\""));
            let objects = [&before.value, &value].map(|v| matches!(v, Value::Object(_)));
            if !*old || objects.contains(&true) {
                return Err(error);
            }
            // The last one counted in version 0.x.
            *before = Property { name, value, place };
            self.document.warn(error);
            return Ok(());
        }
        properties.push(Property { name, value, place });
        Ok(())
    }

    /// The attributes after substitution, the required ones first and in order.
    pub(super) fn attributes<'n>(
        &mut self,
        place: &Place,
        node: Node<'n, '_>,
        required: &[&str],
        optional: &[&str],
    ) -> Result<Attributes<'n>, SceneError> {
        let mut result = Attributes::new();
        for attribute in node.attributes() {
            let name = attribute.name();
            if !required.contains(&name) && !optional.contains(&name) {
                let known = [required, optional].concat().join(", ");
                return Err(
                    place.error(format!("unknown attribute \"{name}\"; supported: {known}"))
                );
            }
            let counts_samples = name == "value" && is_sample_count(node);
            let value = self.parameters.substitute(attribute.value(), counts_samples);
            result.push((name, value.map_err(|e| place.error(e))?));
        }
        for (index, name) in required.iter().enumerate() {
            let Some(at) = result.iter().position(|(key, _)| key == name) else {
                return Err(place.error(format!("the attribute \"{name}\" is missing")));
            };
            result.swap(index, at);
        }
        Ok(result)
    }

    fn include(
        &mut self,
        context: &Context,
        node: Node,
        place: &Place,
        parent: ObjectId,
    ) -> Result<(), SceneError> {
        let a = self.attributes(place, node, &["filename"], &[])?;
        self.includes += 1;
        if context.depth + 1 > MAX_INCLUDE_DEPTH || self.includes > MAX_INCLUDES {
            return Err(place.error(format!(
                "more than {MAX_INCLUDE_DEPTH} nested or {MAX_INCLUDES} includes; \
                 does a file include itself?"
            )));
        }
        let path = find_file(&a[0].1, &context.folders).map_err(|e| place.error(e))?;
        let text = read_text(&path).map_err(|e| place.error(format!("{}: {e}", path.display())))?;
        self.included += text.len() as u64;
        if self.included > MOST_TEXT {
            return Err(place.error(format!("the includes are larger than {MOST_TEXT} bytes")));
        }
        self.document.files.get_mut().push(path.clone());
        let mut folders = vec![path.parent().unwrap_or(Path::new("")).to_path_buf()];
        folders.extend(context.folders.iter().cloned());
        let source = Arc::new(Source { path, text });
        self.read(source, Rc::new(folders), Some(parent), context.depth + 1)
    }

    fn path(
        &mut self,
        context: &mut Context,
        node: Node,
        place: &Place,
        parent: ObjectId,
    ) -> Result<(), SceneError> {
        let a = self.attributes(place, node, &["value"], &[])?;
        if parent != 0 {
            return Err(place.error("only allowed directly inside <scene>"));
        }
        let folder = find_file(&a[0].1, &context.folders).map_err(|e| place.error(e))?;
        if !folder.is_dir() {
            return Err(place.error(format!("{} is not a folder", folder.display())));
        }
        let mut folders = vec![folder];
        folders.extend(context.folders.iter().cloned());
        context.folders = Rc::new(folders);
        Ok(())
    }

    fn alias(&mut self, node: Node, place: &Place) -> Result<(), SceneError> {
        let a = self.attributes(place, node, &["id", "as"], &[])?;
        let Some(&object) = self.document.ids.get(&a[0].1) else {
            return Err(place.error(format!("no object has the id \"{}\" so far", a[0].1)));
        };
        self.name_object(&a[1].1, object, place)
    }

    fn value(&mut self, node: Node, place: &Place) -> Result<(String, Value), SceneError> {
        let tag = node.tag_name().name();
        let parsed = match tag {
            "point" | "vector" => {
                let a = self.attributes(place, node, &["name"], &["value", "x", "y", "z"])?;
                let value = axes(&a, None).map(Value::Vector);
                return match value {
                    Ok(value) => Ok((a[0].1.clone(), value)),
                    Err(e) => Err(place.error(e)),
                };
            }
            "float" | "integer" | "boolean" | "string" | "rgb" | "srgb" | "spectrum" => {
                self.attributes(place, node, &["name", "value"], &[])?
            }
            _ => {
                return Err(place.error(format!(
                    "not supported; supported: {}, default, include, path, alias, ref, \
                     transform, float, integer, boolean, string, rgb, spectrum, point, vector",
                    OBJECTS[1..9].join(", ")
                )));
            }
        };
        let text = parsed[1].1.as_str();
        let value = match tag {
            "float" => values::number(text).map(Value::Float),
            "integer" => values::integer(text).map(Value::Integer),
            "boolean" => values::boolean(text).map(Value::Boolean),
            "string" => Ok(Value::String(text.to_owned())),
            "rgb" => values::rgb(text).map(Value::Rgb),
            "srgb" => values::srgb(text).map(Value::Rgb),
            // Three values are colours in files of version 0.x.
            _ => match values::vector(text) {
                Ok(colour) if values::number(text).is_err() => Ok(Value::Rgb(colour)),
                _ => Spectrum::parse(text).map(Value::Spectrum),
            },
        };
        match value {
            Ok(value) => Ok((parsed[0].1.clone(), value)),
            Err(e) => Err(place.error(e)),
        }
    }

    fn resolve_references(&mut self) -> Result<(), SceneError> {
        for (object, index, id) in &self.references {
            let property = &mut self.document.objects[*object].properties[*index];
            let Some(&target) = self.document.ids.get(id) else {
                return Err(property.place.error(format!("no object has the id \"{id}\"")));
            };
            property.value = Value::Object(target);
        }
        Ok(())
    }
}

impl Context {
    /// The name of a property as it is written today: files before version 2 have `intIOR` for `int_ior`.
    pub(super) fn name(&self, name: &str) -> String {
        if !self.old {
            return name.to_owned();
        }
        let mut result = String::with_capacity(name.len() + 4);
        let mut before = '_';
        for letter in name.chars() {
            if letter.is_ascii_uppercase() && !before.is_ascii_uppercase() && before != '_' {
                result.push('_');
            }
            result.push(letter.to_ascii_lowercase());
            before = letter;
        }
        result
    }

    pub(super) fn place(&self, node: Node) -> Place {
        let tag = node.tag_name().name();
        let key = ["type", "name", "id", "filename"]
            .into_iter()
            .find_map(|key| node.attribute(key).map(|value| (key, value)));
        let element = match key {
            Some((key, value)) => format!("<{tag} {key}=\"{value}\">"),
            None => format!("<{tag}>"),
        };
        Place { source: self.source.clone(), offset: node.range().start, element: element.into() }
    }
}
