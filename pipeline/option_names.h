#pragma once

#include "pipeline/config.h"
#include "slim/base/error.h"

#include <string>
#include <string_view>

namespace slim {

/// The key of an option in a message, `path`, which a command line is told as --path. Marked: in a
/// user's own text, such as a file's name, backquotes stay what they are.
std::string quoted_key(std::string_view key);

/// A fault as a command line says it: with the option of its key, or the one that gave its file
/// (not of words, nor where a line of the file is named), and --key for what quoted_key marked.
///
/// in_a_job  a step of a job says it: -o is the job's, and nobody gave it
Fault with_option_names(const FieldList& fields, Fault fault, bool in_a_job = false);

}  // namespace slim
