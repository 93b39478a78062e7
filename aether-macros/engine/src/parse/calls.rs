//! Closures, and functions within a body: a call is read as what is called, with the arguments in its place.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use quote::ToTokens;
use syn::{Block, Expr, FnArg, Item, Pat, Stmt};

use super::Value;
use super::body::Body;

/// How deep calls may be within each other.
const DEPTH: usize = 32;

/// The constants and functions that are seen within functions of the body.
pub(super) type Items = Rc<RefCell<HashMap<String, Value>>>;

/// What can be called.
pub struct Callable {
    inputs: Vec<Pat>,
    body: Expr,
    known: Known,
    /// Whether it mentions what depends on the first parameter.
    pub(super) depends: bool,
}

/// What names mean in it.
enum Known {
    /// As they did where the closure is.
    Captured(HashMap<String, Value>),
    /// Those of items alone.
    Items(Items),
}

impl core::fmt::Debug for Callable {
    // What it knows may know it.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "|..| {}", self.body.to_token_stream())
    }
}

impl Body<'_> {
    /// Makes the constants and functions of a block known, wherever they are in it.
    pub(super) fn declare_items(&mut self, block: &Block) -> Option<()> {
        let items = || {
            block.stmts.iter().filter_map(|stmt| match stmt {
                Stmt::Item(item) => Some(item),
                _ => None,
            })
        };
        if !items().any(|item| matches!(item, Item::Const(_) | Item::Fn(_))) {
            return Some(());
        }
        let known: Items = Rc::new(RefCell::new(self.items.borrow().clone()));
        for item in items() {
            let Item::Fn(item) = item else { continue };
            let inputs = item.sig.inputs.iter().filter_map(|input| match input {
                FnArg::Typed(input) => Some((*input.pat).clone()),
                FnArg::Receiver(_) => None,
            });
            let block = &item.block;
            let function = Value::Callable(Rc::new(Callable {
                inputs: inputs.collect(),
                body: syn::parse_quote!(#block),
                known: Known::Items(known.clone()),
                depends: false,
            }));
            known.borrow_mut().insert(item.sig.ident.to_string(), function.clone());
            self.declare(&item.sig.ident.to_string(), function);
        }
        self.items = known;
        let mut read = Some(());
        for item in items() {
            let Item::Const(item) = item else { continue };
            let value = self.expr(&item.expr);
            read = read.filter(|()| value.is_some());
            let (name, value) = (item.ident.to_string(), value.unwrap_or(Value::Unknown));
            self.items.borrow_mut().insert(name.clone(), value.clone());
            self.declare(&name, value);
        }
        read
    }

    /// A statement that declares something: a constant and a function are known already, as what is used is.
    pub(super) fn item(&mut self, item: &Item) -> Option<()> {
        match item {
            Item::Const(_) | Item::Fn(_) | Item::Use(_) => {
                if self.depth == 1 {
                    self.making.constants.lets.push(item.to_token_stream());
                }
                Some(())
            }
            other => self.error(other, "of items a body may have `const`, `fn` and `use`: move this one out of the function"),
        }
    }

    /// A closure as a value.
    pub(super) fn closure(&mut self, closure: &syn::ExprClosure) -> Option<Value> {
        Some(Value::Callable(Rc::new(Callable {
            inputs: closure.inputs.iter().cloned().collect(),
            body: (*closure.body).clone(),
            depends: self.depends(closure),
            known: Known::Captured(self.names.clone()),
        })))
    }

    /// The value of a call with arguments that are read where it is.
    pub(super) fn call_with(
        &mut self,
        at: &impl ToTokens,
        callable: &Callable,
        arguments: &[&Expr],
    ) -> Option<Value> {
        let values = arguments.iter().map(|a| self.expr(a)).collect::<Option<Vec<_>>>()?;
        self.apply(at, callable, values)
    }

    /// The value of a function at some values.
    pub(super) fn apply(
        &mut self,
        at: &impl ToTokens,
        callable: &Callable,
        arguments: Vec<Value>,
    ) -> Option<Value> {
        if self.left() {
            return Some(Value::Unit);
        }
        let wanted = callable.inputs.len();
        if arguments.len() != wanted {
            return self
                .error(at, format!("this takes {wanted} arguments, not {}", arguments.len()));
        }
        if self.calls >= DEPTH {
            return self.error(at, "this calls itself, and a formula cannot contain itself: write it as a `for` over a known number of steps, or write the cases out");
        }
        let known = match &callable.known {
            Known::Captured(names) => names.clone(),
            Known::Items(items) => items.borrow().clone(),
        };
        let outer = std::mem::replace(&mut self.names, known);
        let returned = self.returned.take();
        self.calls += 1;
        self.depth += 1;
        let ((value, own), changed) = self.within(|body| {
            let own = callable.inputs.iter().zip(arguments).map(|(p, v)| body.bind(p, v));
            let own = own.fold(Some(()), Option::and);
            let value = own.and_then(|()| body.expr(&callable.body));
            (value, own)
        });
        self.depth -= 1;
        self.calls -= 1;
        let result = self.returned.take();
        self.returned = returned;
        self.names = outer;
        own?;
        if let Some(name) = changed.keys().next() {
            return self.error(&callable.body, format!("a closure gives a value, and this one changes `{name}`, which is not its own: return the new value instead, `{name} = f(…)`"));
        }
        result.or(value)
    }
}
