//! What the derived schemas get wrong.

use std::collections::BTreeSet;

use utoipa::openapi::{OpenApi, RefOr, Schema};

/// Opens every schema that others are composed of.
///
/// Serde refuses unknown members once it has taken out what stands beside
/// them, such as a task's `type`. The schema derived from that forbids further
/// members also where it is a part of an `allOf`, and nothing would be valid.
pub(super) fn open_composed(api: &mut OpenApi) {
    let Some(components) = api.components.as_mut() else { return };
    let mut names = BTreeSet::new();
    let mut forms = BTreeSet::new();
    for schema in components.schemas.values() {
        composed_of(schema, &mut names);
    }
    for name in &names {
        if let Some(RefOr::T(Schema::OneOf(one))) = components.schemas.get(name) {
            forms.extend(one.items.iter().filter_map(name_of));
        }
    }
    for name in names.union(&forms) {
        if let Some(RefOr::T(Schema::Object(object))) = components.schemas.get_mut(name) {
            object.additional_properties = None;
        }
    }
}

/// The name of the schema that is referred to.
fn name_of(item: &RefOr<Schema>) -> Option<String> {
    let RefOr::Ref(reference) = item else { return None };
    reference.ref_location.rsplit('/').next().map(str::to_owned)
}

/// Collects the names of the schemas that stand in an `allOf`.
fn composed_of(schema: &RefOr<Schema>, names: &mut BTreeSet<String>) {
    let RefOr::T(schema) = schema else { return };
    match schema {
        Schema::AllOf(all) => {
            for item in &all.items {
                names.extend(name_of(item));
                composed_of(item, names);
            }
        }
        Schema::OneOf(one) => one.items.iter().for_each(|item| composed_of(item, names)),
        Schema::Object(object) => {
            object.properties.values().for_each(|item| composed_of(item, names));
        }
        _ => {}
    }
}
