#pragma once

#include <filesystem>
#include <initializer_list>
#include <string>

namespace slim {

/// What a path that was given leads to, for messages that say what to do with it.
enum class InputKind { missing, folder, model, cloud, other };

/// Looks at the first bytes; a cloud is what yields a point. Never throws.
InputKind input_kind(const std::string& path);

/// FormatError that says how to make a model of it if the path is a cloud, and what is wrong with
/// if it would be a cloud (by its first bytes or name) but cannot be read; ConfigError that says
/// what a model is if it is a folder; anything else is left to the reader.
void require_model(const std::string& path);

/// Throws ConfigError if an output is one of the inputs, under whatever name;
/// empty names are passed over.
void refuse_to_overwrite(const std::string& output, std::initializer_list<std::string> inputs);

/// Throws ConfigError if a model would take the place of a cloud or of any other file. Models,
/// empty files and what is named .slim without being a cloud (a damaged model) may be replaced.
void refuse_to_replace_other(const std::string& output);

/// Throws ConfigError if a model's name ends as a file of some other format does (.ply, .png, .json
/// ...): other programs would take it for one. Any other name is fine:
/// a model is known by its first bytes.
void refuse_other_ending(const std::string& model);

/// Makes a folder for outputs, and those above it, where there is none. IoError (2) if that cannot
/// be.
void make_writable_folder(const std::filesystem::path& folder);

}  // namespace slim
