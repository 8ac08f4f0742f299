#pragma once

#include <string>

namespace slim {

/// What a path that was given leads to, for messages that say what to do with it.
enum class InputKind { missing, folder, model, cloud, other };

/// Looks at the first bytes; a cloud is what yields a point. Never throws.
InputKind input_kind(const std::string& path);

/// FormatError that says how to make a model of it if the path is a cloud, and what a model is if
/// it is a folder; anything else is left to the reader.
void require_model(const std::string& path);

}  // namespace slim
