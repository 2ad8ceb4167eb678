//! Tables as CSV.

use serde_json::Value;

/// A line of a table: values by the names of their columns, in the order of the columns.
pub type Record = Vec<(&'static str, Value)>;

/// Records as CSV, under the names of their columns.
pub fn csv(records: &[Record]) -> String {
    let text = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let head = records.first().map(|record| record.iter().map(|(name, _)| name.to_string()).collect::<Vec<_>>());
    let lines = records.iter().map(|record| record.iter().map(|(_, value)| text(value)).collect());
    head.into_iter().chain(lines).map(|line| line.join(",") + "\n").collect()
}
