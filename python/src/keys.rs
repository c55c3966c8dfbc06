//! Values of Python as values of TOML.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use sim_harness::scenario::Setting;
use toml::Value;

/// The settings of a dictionary: its keys have dots, or its values are dictionaries.
pub(crate) fn settings(keys: &Bound<'_, PyDict>) -> PyResult<Vec<Setting>> {
    let mut settings = Vec::new();
    flatten(keys, "", &mut settings)?;
    Ok(settings)
}

fn flatten(keys: &Bound<'_, PyDict>, above: &str, into: &mut Vec<Setting>) -> PyResult<()> {
    for (key, value) in keys {
        let key = format!("{above}{}", name(above, &key)?);
        match value.cast::<PyDict>() {
            // A law of the path loss is one whole: it does not mix with that of the file.
            Ok(_) if above.is_empty() && key == "radio.model" => {
                into.push(Setting::new(key.clone(), self::value(&key, &value)?));
            }
            Ok(below) => flatten(below, &format!("{key}."), into)?,
            Err(_) => into.push(Setting::new(key.clone(), self::value(&key, &value)?)),
        }
    }
    Ok(())
}

/// The value of a key.
pub(crate) fn value(key: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    // A bool is an int to Python.
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(flag.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        let whole = value.extract().map_err(|_| {
            PyValueError::new_err(format!("{key}={value} is out of range; give a smaller number"))
        })?;
        return Ok(Value::Integer(whole));
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Float(value.extract()?));
    }
    if value.is_instance_of::<PyString>() {
        return Ok(Value::String(value.extract()?));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let each = value.try_iter()?.map(|entry| self::value(key, &entry?));
        return Ok(Value::Array(each.collect::<PyResult<_>>()?));
    }
    if let Ok(dict) = value.cast::<PyDict>() {
        let each = dict
            .iter()
            .map(|(name, entry)| Ok((self::name(key, &name)?, self::value(key, &entry)?)));
        return Ok(Value::Table(each.collect::<PyResult<_>>()?));
    }
    // The numbers and arrays of numpy, which are none of these. Others have methods of that name that
    // give something else.
    if let Ok(plain) = value.call_method0("tolist")
        && (plain.is_instance_of::<PyInt>()
            || plain.is_instance_of::<PyFloat>()
            || plain.is_instance_of::<PyList>())
    {
        return self::value(key, &plain);
    }
    let kind = value.get_type().name()?;
    let text = format!(
        "{key}: a value of the type {kind} is none of a scenario; give a number, a \
                        string, a bool, a list or a dict"
    );
    Err(PyValueError::new_err(text))
}

/// The name of a key within this one.
fn name(above: &str, key: &Bound<'_, PyAny>) -> PyResult<String> {
    key.extract().map_err(|_| {
        let place = if above.is_empty() { "the scenario" } else { above.trim_end_matches('.') };
        PyValueError::new_err(format!("{key} in {place}: the name of a key is a string"))
    })
}
