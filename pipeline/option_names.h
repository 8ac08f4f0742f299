#pragma once

#include "pipeline/config.h"

#include <string>
#include <string_view>

namespace slim {

/// The key of an option in a message, `path`, which a command line is told as --path. Marked: in a
/// user's own text, such as a file's name, backquotes stay what they are.
std::string quoted_key(std::string_view key);

/// A message with keys as a command line has them: --key for what quoted_key marked, and for a key
/// that begins the message unless a path that was given begins it, too (a file that is called as an
/// option is). A path that an option gave has the option before it, unless a line of it is named.
///
/// in_a_job  a step of a job says it: -o is the job's, and nobody gave it
std::string with_option_names(const FieldList& fields, std::string what, bool in_a_job = false);

}  // namespace slim
