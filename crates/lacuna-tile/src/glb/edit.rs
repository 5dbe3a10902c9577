//! JSON that is changed in places only: what is not touched keeps its text, its order and its numbers as written.

use serde::de::{Error as _, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::value::RawValue;
use std::fmt;

/// A JSON object whose members are text, in the order written.
#[derive(Debug, Default)]
pub(super) struct RawObject {
    members: Vec<(String, Box<RawValue>)>,
}

impl RawObject {
    /// Parses an object; a repeated key is an error.
    pub(super) fn parse(text: &str) -> serde_json::Result<Self> {
        serde_json::from_str(text)
    }

    /// The text of a member.
    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.members.iter().find(|(name, _)| name == key).map(|(_, value)| value.get())
    }

    /// Replaces a member where it stands, or appends it.
    pub(super) fn set(&mut self, key: &str, value: &impl Serialize) -> serde_json::Result<()> {
        let value = RawValue::from_string(serde_json::to_string(value)?)?;
        match self.members.iter_mut().find(|(name, _)| name == key) {
            Some((_, old)) => *old = value,
            None => self.members.push((key.to_owned(), value)),
        }
        Ok(())
    }

    /// The elements of an array member; none if there is no such member.
    pub(super) fn array(&self, key: &str) -> serde_json::Result<Vec<Box<RawValue>>> {
        self.get(key).map_or(Ok(Vec::new()), serde_json::from_str)
    }

    /// Appends elements to an array member, which is made if need be.
    pub(super) fn extend(&mut self, key: &str, values: &[impl Serialize]) -> serde_json::Result<()> {
        if values.is_empty() {
            return Ok(());
        }
        let mut array = self.array(key)?;
        for value in values {
            array.push(RawValue::from_string(serde_json::to_string(value)?)?);
        }
        self.set(key, &array)
    }

    /// Changes the object that stands at `index` of an array member.
    pub(super) fn edit_element(
        &mut self,
        key: &str,
        index: usize,
        change: impl FnOnce(&mut Self) -> serde_json::Result<()>,
    ) -> serde_json::Result<()> {
        let mut array = self.array(key)?;
        let Some(element) = array.get_mut(index) else {
            return Err(serde_json::Error::custom(format!("{key} has no element {index}")));
        };
        let mut object = Self::parse(element.get())?;
        change(&mut object)?;
        *element = RawValue::from_string(serde_json::to_string(&object)?)?;
        self.set(key, &array)
    }
}

impl Serialize for RawObject {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.members.len()))?;
        for (key, value) in &self.members {
            map.serialize_entry(key, value)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for RawObject {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Members)
    }
}

struct Members;

impl<'de> Visitor<'de> for Members {
    type Value = RawObject;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawObject, A::Error> {
        let mut object = RawObject::default();
        while let Some((key, value)) = map.next_entry::<String, Box<RawValue>>()? {
            if object.get(&key).is_some() {
                return Err(A::Error::custom(format!("the key {key:?} stands twice")));
            }
            object.members.push((key, value));
        }
        Ok(object)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_touched_keeps_its_text() {
        let text = r#"{"z":1.0,"a":[ {"x":1e3,"u":"é"} ,2.50],"n":123456789012345678901234567890}"#;
        let mut object = RawObject::parse(text).expect("object");
        assert_eq!(serde_json::to_string(&object).expect("text"), text);
        object.edit_element("a", 0, |o| o.set("y", &[1])).expect("edited");
        object.extend("a", &["new"]).expect("extended");
        object.extend("b", &[7]).expect("made");
        assert_eq!(
            serde_json::to_string(&object).expect("text"),
            r#"{"z":1.0,"a":[{"x":1e3,"u":"é","y":[1]},2.50,"new"],"n":123456789012345678901234567890,"b":[7]}"#
        );
    }

    #[test]
    fn odd_texts_are_errors() {
        for text in ["[]", "{\"a\":1,\"a\":2}", "{\"a\":}", "", "1"] {
            assert!(RawObject::parse(text).is_err(), "{text}");
        }
        let mut object = RawObject::parse("{\"a\":{}}").expect("object");
        assert!(object.extend("a", &[1]).is_err(), "no array");
        assert!(object.edit_element("b", 0, |_| Ok(())).is_err(), "no element");
    }
}
