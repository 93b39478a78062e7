//! Emits the items of a strategy: the hidden function, the struct, its constructor, the trait.

use proc_macro2::{Span, TokenStream};
use quote::{ToTokens, quote, quote_spanned};
use syn::spanned::Spanned;
use syn::{Expr, GenericParam, Ident, ItemFn, Type, parse_quote};

use super::analyse::Analysed;
use super::names::{delegate, form, is_stop, referenced};
use super::reads::{Reads, comparisons};
use super::signature::{Field, Signature};
use super::tree::{Apart, Body, Form, Kind, Other, Plan, Step};
use super::{density, sample};
use crate::diagnostics::is_lint;
use crate::walk;

/// Everything that the attribute emits; without a plan the methods are left unimplemented.
pub fn item(
    function: &ItemFn,
    signature: &Signature,
    documentation: &str,
    reads: Reads,
    plan: Option<&Analysed>,
) -> TokenStream {
    let hidden = hidden(function, Some(signature));
    let structure = structure(function, signature);
    let constructor = constructor(function, signature, documentation);
    let strategy = strategy(function, signature, reads, plan);
    quote!(#structure #constructor #hidden #strategy)
}

/// The function as it was written, for type checking and editors; nobody can call it.
pub fn hidden(function: &ItemFn, signature: Option<&Signature>) -> TokenStream {
    let mut copy = function.clone();
    copy.vis = syn::Visibility::Inherited;
    copy.attrs.retain(is_lint);
    if let Some(Signature { vertex, yields, count, path, .. }) = signature {
        let real = real(vertex);
        let qualify = Qualify { real: &real, vertex: yields, joint: *count > 1 };
        walk::change_block(&mut |expr| qualify.expr(expr), &mut copy.block);
        // A strategy that does not look at the path has the parameter all the same.
        copy.block.stmts.insert(0, parse_quote!(let _ = &#path;));
    }
    quote! {
        const _: () = {
            #[allow(dead_code, clippy::needless_pass_by_value, clippy::trivially_copy_pass_by_ref)]
            #copy
        };
    }
}

fn real(vertex: &Type) -> TokenStream {
    quote!(<#vertex as ::aether_core::strategy::Vertex>::Real)
}

/// Makes the special forms name functions of the runtime.
struct Qualify<'a> {
    real: &'a TokenStream,
    vertex: &'a Type,
    /// Whether there are several vertices.
    joint: bool,
}

impl Qualify<'_> {
    fn expr(&self, expr: &mut Expr) -> bool {
        if let Expr::Return(_) = expr
            && is_stop(expr)
            && let Expr::Return(ret) = expr
            && let Some(stop) = ret.expr.take()
        {
            *expr = *stop;
        }
        if let Expr::MethodCall(call) = expr
            && call.method == "identified_by"
            && let Some((name, choice)) = form(&call.receiver)
            && name == "choose"
        {
            let (real, vertex) = (self.real, self.vertex);
            let (distribution, rule) = (&choice.args, &call.args);
            let function = Ident::new("choose_identified", name.span());
            *expr = parse_quote! {
                ::aether_core::forms::#function::<#vertex, #real, _, _>(#distribution, #rule)
            };
        } else if self.joint && delegate(expr).is_some() {
            // It is refused, and has no type: that alone is the error.
            *expr = parse_quote!(::aether_core::forms::stop());
        } else if let Some((name, call)) = form(expr) {
            let (real, vertex) = (self.real, self.vertex);
            let generics = match name.to_string().as_str() {
                "choose" | "draw" | "atom" => quote!(::<#real, _>),
                "delegate" => quote!(::<#vertex, _>),
                _ => TokenStream::new(),
            };
            let arguments = &call.args;
            *expr = parse_quote!(::aether_core::forms::#name #generics (#arguments));
        }
        true
    }
}

fn names(fields: &[Field]) -> Vec<&Ident> {
    fields.iter().map(|field| &field.name).collect()
}

/// The struct, and `Clone` for it.
fn structure(function: &ItemFn, signature: &Signature) -> TokenStream {
    let Signature { name, generics, fields, .. } = signature;
    let visibility = &function.vis;
    let (implementation, arguments, conditions) = generics.split_for_impl();
    let names = names(fields);
    let types: Vec<_> = fields.iter().map(|field| &field.ty).collect();
    let (marker, marker_type) = marker(signature);
    let marker_field = marker_type.map(|ty| quote!(#marker: #ty,));
    let marker_value = marker_field.as_ref().map(|_| quote!(#marker: ::core::marker::PhantomData,));
    let documentation = format!("The strategy that [`{}`](fn@{0}) returns.", function.sig.ident);
    let cloned = cloneable(signature);
    let conditions_and = and(conditions, &cloned);
    quote! {
        #[doc = #documentation]
        #visibility struct #name #generics #conditions { #(#names: #types,)* #marker_field }

        #[automatically_derived]
        #[allow(clippy::all, clippy::pedantic)]
        impl #implementation ::core::clone::Clone for #name #arguments #conditions_and {
            #[inline]
            fn clone(&self) -> Self {
                Self { #(#names: ::core::clone::Clone::clone(&self.#names),)* #marker_value }
            }
        }
    }
}

/// What cloning asks of the parameters: nothing of references.
fn cloneable(signature: &Signature) -> Vec<TokenStream> {
    let owned = signature.fields.iter().map(|field| &field.ty).filter(|ty| !is_reference(ty));
    owned.map(|ty| quote!(#ty: ::core::clone::Clone)).collect()
}

fn is_reference(ty: &Type) -> bool {
    matches!(ty, Type::Reference(reference) if reference.mutability.is_none())
}

fn is_number(ty: &Type) -> bool {
    matches!(ty, Type::Path(path) if path.path.is_ident("f32") || path.path.is_ident("f64"))
}

fn and(conditions: Option<&syn::WhereClause>, more: &[TokenStream]) -> TokenStream {
    let given = conditions.map(|clause| {
        let predicates = clause.predicates.iter();
        quote!(#(#predicates,)*)
    });
    quote!(where #given #(#more,)*)
}

/// The field that stands for generics which no parameter mentions.
fn marker(signature: &Signature) -> (Ident, Option<TokenStream>) {
    let mut name = "marker".to_owned();
    while signature.fields.iter().any(|field| field.name == name) {
        name.push('_');
    }
    let unused = signature.unused.iter().map(|parameter| match parameter {
        GenericParam::Lifetime(parameter) => {
            let lifetime = &parameter.lifetime;
            quote!(&#lifetime ())
        }
        GenericParam::Type(parameter) => parameter.ident.to_token_stream(),
        GenericParam::Const(_) => TokenStream::new(),
    });
    let unused: Vec<_> = unused.collect();
    let ty =
        (!unused.is_empty()).then(|| quote!(::core::marker::PhantomData<fn() -> (#(#unused,)*)>));
    (Ident::new(&name, Span::mixed_site()), ty)
}

fn constructor(function: &ItemFn, signature: &Signature, documentation: &str) -> TokenStream {
    let Signature { name, generics, fields, .. } = signature;
    let (visibility, ident) = (&function.vis, &function.sig.ident);
    let (_, arguments, conditions) = generics.split_for_impl();
    let attributes = function.attrs.iter().filter(|attribute| !is_lint(attribute));
    let names = names(fields);
    let types = fields.iter().map(|field| &field.ty);
    let (marker, marker_type) = marker(signature);
    let marker = marker_type.map(|_| quote!(#marker: ::core::marker::PhantomData));
    quote! {
        #(#attributes)*
        #[doc = #documentation]
        #[must_use]
        #[allow(clippy::all, clippy::pedantic)]
        #visibility fn #ident #generics (#(#names: #types),*) -> #name #arguments #conditions {
            #name { #(#names,)* #marker }
        }
    }
}

fn strategy(
    function: &ItemFn,
    signature: &Signature,
    reads: Reads,
    analysed: Option<&Analysed>,
) -> TokenStream {
    let Signature { name, vertex, generics, .. } = signature;
    let (implementation, arguments, conditions) = generics.split_for_impl();
    let conditions = and(conditions, &cloneable(signature));
    let site = Span::mixed_site();
    let methods = if signature.count == 1 {
        methods(signature, analysed)
    } else {
        joint_methods(signature, analysed)
    };
    let ways = analysed.filter(|analysed| analysed.has_ways());
    let ways = ways.map(|analysed| {
        let Signature { yields, .. } = signature;
        let (prelude, real) = (prelude(signature), real(vertex));
        let density = density::density(analysed, yields, signature.count > 1, &real);
        quote_spanned! {site=>
            #[allow(unused, unreachable_code, irrefutable_let_patterns, clippy::all, clippy::pedantic)]
            impl #implementation #name #arguments #conditions {
                /// The density; if `OTHERS`, without the way that was `taken` to the vertex `way`.
                fn __density<const OTHERS: bool>(
                    &self,
                    view: ::aether_core::sequence::PathView<'_, #vertex>,
                    target: &#yields,
                    taken: &[usize],
                    way: usize,
                ) -> #real {
                    #prelude
                    #density
                }
            }
        }
    });
    let plan = analysed.map(|analysed| &analysed.plan);
    let atoms = atoms(signature, plan);
    let classes = classes(function, signature, plan);
    let reads = declared(signature, reads, plan);
    let same = same(signature, plan);
    let module = quote!(::aether_core::strategy);
    quote_spanned! {site=>
        #[automatically_derived]
        #[allow(unused, unreachable_code, irrefutable_let_patterns, clippy::all, clippy::pedantic)]
        impl #implementation #module::Strategy<#vertex> for #name #arguments #conditions {
            const ATOMS: #module::Atoms = #atoms;

            #methods

            #[inline]
            fn reads(&self) -> #module::Reads {
                #reads
            }

            #classes

            fn same(&self, other: &Self) -> bool {
                #same
            }
        }

        #ways
    }
}

/// The density of `target`.
fn density(signature: &Signature, analysed: &Analysed, real: &TokenStream) -> TokenStream {
    let site = Span::mixed_site();
    if analysed.has_ways() {
        return quote_spanned!(site=> self.__density::<false>(view, target, &[], 0));
    }
    let prelude = prelude(signature);
    let density = density::density(analysed, &signature.yields, signature.count > 1, real);
    quote_spanned!(site=> { #prelude #density })
}

/// `sample` and `pdf` of a strategy of one vertex.
fn methods(signature: &Signature, analysed: Option<&Analysed>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let (real, prelude) = (real(vertex), prelude(signature));
    let (sample, pdf) = match analysed {
        Some(analysed @ Analysed { apart, .. }) => {
            let sample = sample::sample(analysed, &real);
            let apart = (!apart.is_empty()).then(|| {
                let checks = apart.iter().map(|apart| told_apart(apart, vertex));
                // Parameters of their own, because naming the type of an expression may move them.
                let parameters = parameters(signature);
                quote!({ #parameters #(#checks)* })
            });
            let value = density(signature, analysed, &real);
            let pdf = quote_spanned! {site=>
                let dirac = ::aether_core::sequence::PathView::dirac(&view);
                ::aether_core::strategy::Conditional { value: #value, dirac }
            };
            (quote!(#prelude #sample), quote!(#apart #pdf))
        }
        None => (quote!(::core::unimplemented!()), quote!(::core::unimplemented!())),
    };
    let module = quote!(::aether_core::strategy);
    quote_spanned! {site=>
        fn sample<U: ::aether_core::UniformSource<#real> + ?::core::marker::Sized>(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            uniforms: &mut U,
        ) -> ::core::option::Option<#module::Drawn<#vertex>> {
            #sample
        }

        fn pdf(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            target: &#vertex,
        ) -> #module::Conditional<#real> {
            #pdf
        }
    }
}

/// The methods of a strategy of several vertices: it never yields a single one.
fn joint_methods(signature: &Signature, analysed: Option<&Analysed>) -> TokenStream {
    let Signature { vertex, yields, count, .. } = signature;
    let (site, real, prelude) = (Span::mixed_site(), real(vertex), prelude(signature));
    let (sample, pdf) = match analysed {
        Some(analysed) => {
            let sample = sample::sample(analysed, &real);
            let value = density(signature, analysed, &real);
            let pdf = quote_spanned! {site=>
                let ::core::result::Result::Ok(target) = <&#yields>::try_from(targets) else {
                    return <#real as ::aether_core::Real>::ZERO;
                };
                let view = ::aether_core::sequence::PathView::asking(
                    view, ::core::option::Option::None,
                );
                #value
            };
            (quote!(#prelude #sample), pdf)
        }
        None => (quote!(::core::unimplemented!()), quote!(::core::unimplemented!())),
    };
    let module = quote!(::aether_core::strategy);
    quote_spanned! {site=>
        const VERTICES: usize = #count;

        fn sample<U: ::aether_core::UniformSource<#real> + ?::core::marker::Sized>(
            &self,
            _: ::aether_core::sequence::PathView<'_, #vertex>,
            _: &mut U,
        ) -> ::core::option::Option<#module::Drawn<#vertex>> {
            ::core::option::Option::None
        }

        fn pdf(
            &self,
            _: ::aether_core::sequence::PathView<'_, #vertex>,
            _: &#vertex,
        ) -> #module::Conditional<#real> {
            #module::Conditional::ZERO
        }

        fn sample_joint<U: ::aether_core::UniformSource<#real> + ?::core::marker::Sized>(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            uniforms: &mut U,
        ) -> ::core::option::Option<#module::DrawnRun<#vertex>> {
            let mut draw = || -> ::core::option::Option<#module::Drawn<#yields>> { #sample };
            ::core::option::Option::map(draw(), ::core::convert::From::from)
        }

        fn pdf_joint(
            &self,
            view: ::aether_core::sequence::PathView<'_, #vertex>,
            targets: &[#vertex],
        ) -> #real {
            #pdf
        }
    }
}

/// Makes sure that two strategies, or one and an atom of the body, can be told apart.
fn told_apart(Apart { strategy, other }: &Apart, vertex: &Type) -> TokenStream {
    let site = strategy.span().resolved_at(Span::mixed_site());
    let emitted = quote_spanned!(site=> ::aether_core::forms::emitted);
    match other {
        Other::Atom(direction) => quote_spanned! {site=>
            #emitted::apart_from_atom::<#vertex, _, #direction>(|| #strategy);
        },
        Other::Strategy(other) => quote_spanned! {site=>
            #emitted::apart_from::<#vertex, _, _>(|| #strategy, || #other);
        },
    }
}

/// The kinds of atoms that the body or the strategies that it delegates to may yield: any if their
/// types have no name here.
fn atoms(signature: &Signature, plan: Option<&Plan>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let module = quote_spanned!(site=> ::aether_core::strategy);
    let (mut position, mut direction) = (false, false);
    let mut others = Vec::new();
    if let Some(plan) = plan {
        plan.walk(&mut |_| {}, &mut |leaf| match leaf.kind {
            Kind::Density(_) => {}
            Kind::AtomPosition => position = true,
            Kind::AtomDirection(_) => direction = true,
        });
        plan.delegates(&mut |strategy| {
            let field = referenced(strategy)
                .and_then(|name| signature.fields.iter().find(|field| field.name == *name));
            others.push(match field {
                Some(Field { ty, .. }) => {
                    quote_spanned!(site=> <#ty as #module::Strategy<#vertex>>::ATOMS)
                }
                None => quote_spanned!(site=> #module::Atoms::ANY),
            });
        });
    }
    quote_spanned! {site=>
        #module::Atoms { position: #position, direction: #direction } #(.and(#others))*
    }
}

/// What the body reads of the path, and what the strategies read that it delegates to.
fn declared(signature: &Signature, reads: Reads, plan: Option<&Plan>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let Reads { vertices, length } = reads;
    let vertices =
        if vertices == usize::MAX { quote!(usize::MAX) } else { vertices.to_token_stream() };
    let mut delegates = Vec::new();
    if let Some(plan) = plan {
        plan.delegates(&mut |strategy| delegates.push(strategy));
    }
    let parameters = (!delegates.is_empty()).then(|| parameters(signature));
    quote_spanned! {site=>
        #parameters
        ::aether_core::strategy::Reads { vertices: #vertices, length: #length }
            #(.and(::aether_core::strategy::Strategy::<#vertex>::reads(&#delegates)))*
    }
}

/// The method that says which lengths of the path make no difference, where the body only compares the length.
fn classes(function: &ItemFn, signature: &Signature, plan: Option<&Plan>) -> Option<TokenStream> {
    let site = Span::mixed_site();
    let mut delegates = false;
    plan?.delegates(&mut |_| delegates = true);
    if delegates {
        return None;
    }
    let fixed = signature.fields.iter().filter(|field| !field.mutable);
    let names: Vec<&Ident> = fixed.map(|field| &field.name).collect();
    let comparisons = comparisons(&function.block, &signature.path, &names)?;
    let parameters = parameters(signature);
    Some(quote_spanned! {site=>
        #[inline]
        fn length_class(&self, len: usize) -> u32 {
            #parameters
            let class = 0;
            #(let class = 2 * class + u32::from(#comparisons);)*
            class
        }
    })
}

/// Binds the path and the parameters to their names.
fn prelude(signature: &Signature) -> TokenStream {
    let site = Span::mixed_site();
    let path = &signature.path;
    let reference = signature.path_by_reference.then(|| quote!(&));
    let parameters = parameters(signature);
    quote_spanned!(site=> let #path = #reference view; #parameters)
}

/// Binds the parameters to their names.
fn parameters(signature: &Signature) -> TokenStream {
    let site = Span::mixed_site();
    let fields = signature.fields.iter().map(|field| {
        let Field { name, mutable, ty } = field;
        let mutable = mutable.then(|| quote!(mut));
        if is_reference(ty) {
            quote_spanned!(site=> let #mutable #name = self.#name;)
        } else {
            quote_spanned!(site=> let #mutable #name = ::core::clone::Clone::clone(&self.#name);)
        }
    });
    quote_spanned!(site=> #(#fields)*)
}

/// Whether two strategies have the same arguments, as far as that can be told: references by
/// address, numbers by their bits, as zeros of different signs are equal and yet not the same, strategies to
/// delegate to by asking them, and all else by equality.
fn same(signature: &Signature, plan: Option<&Plan>) -> TokenStream {
    let (site, vertex) = (Span::mixed_site(), &signature.vertex);
    let some = quote_spanned!(site=> ::core::option::Option::Some);
    let mut strategies = Vec::new();
    if let Some(plan) = plan {
        plan.delegates(&mut |strategy| strategies.extend(referenced(strategy)));
    }
    let equal = signature.fields.iter().map(|Field { name, ty, .. }| {
        if is_reference(ty) {
            quote_spanned!(site=> ::core::ptr::eq(self.#name, other.#name))
        } else if is_number(ty) {
            quote_spanned!(site=> self.#name.to_bits() == other.#name.to_bits())
        } else if strategies.contains(&name) {
            quote_spanned! {site=>
                ::aether_core::strategy::Strategy::<#vertex>::same(&self.#name, &other.#name)
            }
        } else {
            // Equal, if the type knows equality.
            quote_spanned!(site=> (&Alike(&self.#name, &other.#name)).alike() == #some(true))
        }
    });
    quote_spanned! {site=>
        #[allow(unused_imports)]
        use ::aether_core::forms::emitted::{Alike, ByEquality as _, Otherwise as _};
        true #(&& #equal)*
    }
}

/// What the density sums over, as Markdown.
pub fn documentation(body: &Body) -> String {
    let mut lines = Vec::new();
    let mut add = |line: String| {
        if !lines.contains(&line) {
            lines.push(line);
        }
    };
    let mut ends = 0;
    body.walk(
        &mut |step| {
            if let Step::Bind { pat, form } = step {
                add(describe(&source(pat), form));
            }
        },
        &mut |_| ends += 1,
    );
    body.delegates(&mut |strategy| {
        ends += 1;
        lines.push(format!("the vertex of `{}`", source(strategy)));
    });
    let lines: String = lines.iter().map(|line| format!("\n- {line}")).collect();
    let ways = if ends == 1 { "one way".to_owned() } else { format!("{ends} ways") };
    format!(
        "\n\n# Distribution\n\nDerived: the density sums over all outcomes of the discrete choices, \
         and {ways} to make the vertex.\n{lines}"
    )
}

fn describe(name: &str, form: &Form) -> String {
    match form {
        Form::Choose { distribution, rule: None } => {
            format!("choice `{name}` of `{}`, enumerated", source(distribution))
        }
        Form::Choose { distribution, rule: Some(_) } => {
            format!("choice `{name}` of `{}`, identified from the vertex", source(distribution))
        }
        Form::Draw(sampler) => format!("random variable `{name}` of `{}`", source(sampler)),
        Form::Constant(call) => {
            format!("locally constant `{name}` of `{}`, read from the vertex", source(call))
        }
        Form::Atom(atom) => format!("draws `{name}`, always the same: `{}`", source(atom)),
        Form::Given(value) => format!("given `{name}`, `{}`", source(value)),
    }
}

/// Tokens as they are usually written.
fn source(tokens: &impl ToTokens) -> String {
    const TIGHT: [(&str, &str); 9] = [
        (" . ", "."),
        (" (", "("),
        ("( ", "("),
        (" )", ")"),
        (" ,", ","),
        (" :: ", "::"),
        ("& ", "&"),
        (":: ", "::"),
        (" ::", "::"),
    ];
    let text = tokens.to_token_stream().to_string().replace(['\n', '`'], " ");
    TIGHT.iter().fold(text, |text, (loose, tight)| text.replace(loose, tight))
}
