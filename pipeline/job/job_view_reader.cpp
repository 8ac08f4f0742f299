#include "pipeline/job/job_view_reader.h"

#include "pipeline/job/job_left_out.h"
#include "pipeline/job/job_own_keys.h"
#include "pipeline/job/job_tables.h"
#include "pipeline/job/job_views.h"
#include "pipeline/job/view_shares.h"
#include "pipeline/manifest.h"
#include "pipeline/render/render_check.h"
#include "pipeline/render/render_config.h"
#include "pipeline/render/render_lights.h"
#include "pipeline/render/render_uses.h"
#include "pipeline/render/render_view.h"
#include "slim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace slim {
namespace {

namespace fs = std::filesystem;

/// The tables that say what is drawn.
class ViewReader {
public:
    ViewReader(const JobPictures& pictures, Job& job)
        : file_(pictures.file),
          root_(pictures.root),
          usual_aovs_(pictures.usual_aovs),
          model_(pictures.model),
          picture_(pictures.picture),
          overridden_(pictures.overridden),
          job_(job) {}

    void read_views() {
        std::vector<std::string> defaults;
        if (const TomlTable* found = find_table(root_, "render", file_)) {
            const TomlTable table = without_replaced(*found);
            defaults = read_options<RenderConfig>(table, file_, all_views_, kOwnedOfRender);
            check_view(table, render_);
            job_.unit = render_.unit;
        }
        read_lights(defaults);
        for (const TomlTable& table : root_.tables)
            if (table.name == "view") read_view(table, defaults);
        if (names_.empty()) job_.left_out.push_back("pictures: there is no [[view]]");
        else refuse_idle();
        leave_room();
    }

    void note_left_out() {
        for (std::string& line : left_out_of_views(asked_, job_.stages))
            job_.left_out.push_back(std::move(line));
        MissingInViews missing = missing_in_views(asked_, job_.stages);
        job_.missing = std::move(missing.certain), job_.uncertain = std::move(missing.uncertain);
    }

private:
    /// [[light]] tables say what --light says in one line: kind = "sun", azimuth = 300.
    void read_lights(std::vector<std::string>& defaults) {
        std::string all;
        for (const TomlTable& table : root_.tables) {
            if (table.name != "light") continue;
            check_tables(table, {}, file_);
            std::string kind, words;
            for (const TomlValue& value : table.values) {
                const std::string text = fmt::format("{}", fmt::join(value.items, ","));
                if (value.key == "kind") kind = text;
                else words += fmt::format(" {}={}", value.key, text);
            }
            try {
                check_lights(kind + words);
            } catch (const ConfigError& error) {
                throw error.at(toml_fault(file_, table.line));
            }
            all += (all.empty() ? "" : "; ") + kind + words;
        }
        if (all.empty()) return;
        if (render_.light != RenderConfig{}.light)
            throw ConfigError(
                file_.string() +
                ": both [[light]] tables and light in [render]: expected one of the two");
        render_.light = all;
        defaults.push_back("--light=" + all);
    }

    void read_view(const TomlTable& table, const std::vector<std::string>& defaults) {
        check_tables(table, {}, file_);
        ViewTable view;
        view.shares = all_views_.shares;
        std::vector<std::string> own =
            read_options<RenderConfig>(table, file_, view, kOwnedOfView);
        RenderConfig render = render_;
        const std::set<std::string> replaced = replaced_by_view(table);
        if (replaced.contains("supersample")) render.supersample = RenderConfig{}.supersample;
        if (replaced.contains("antialias")) render.antialias = false;
        check_view(table, render);
        if (view.aovs.empty()) view.aovs = usual_aovs_;
        check_aovs(view.aovs, table);
        std::set<std::string> own_keys = keys_of(table);
        own_keys.insert(replaced.begin(), replaced.end());
        std::vector<std::string> options = options_for(view.aovs, defaults, own_keys, render);
        note_taken(options, own_keys);
        if (overridden_) own = options_for(view.aovs, own, {}, render);
        const std::string own_name = view.name.empty() ? name_of(options, own) : view.name;
        // By the names that were given: a view's own are made of them.
        check_line_names(options, [&](const std::string& key) { return place_of_default(key); });
        check_line_names(own, [&](const std::string& key) { return place_of_value(table, key); });
        if (n_views() > 1) name_line_files(own_name, options);
        options.insert(options.end(), own.begin(), own.end());
        view.name = own_name;
        at_their_keys(table, [&] { check_view_name(view.name); });
        const bool is_refused = is_beyond_fit(view.aovs, render, table);
        if (!names_.insert(view.name).second) refuse_second(view.name, table);
        check_all(render, view, table);
        asked_.push_back({view.name, view.aovs, render, is_refused});
        JobStep step{"view " + view.name, "render", {model_.string()}, {model_}, {}, {}, {}};
        step.line = table.line;
        for (const fs::path& file : files_read(options)) step.inputs.push_back(file);
        append_arguments(step, options);
        step.arguments.push_back(fmt::format("--aov={}", fmt::join(view.aovs, ",")));
        // Several AOVs become name.shaded.png, name.mean.png; one is to be named alike. An EXR
        // holds all of them.
        const bool exr = render.format == "exr";
        const std::string aov = view.aovs.size() == 1 && !exr ? "." + view.aovs[0] : "";
        const std::string file = view.name + aov + (exr ? ".exr" : ".png");
        step.output = picture_.empty() ? job_.folder / file : picture_;
        add_step_output(step, job_);
        step.products = view_pictures(job_.folder, view.name, view.aovs, render);
        for (const fs::path& lines : line_files(options)) {
            check_line_file(lines, view.name, table);
            step.products.push_back(lines);
        }
        views_.push_back({job_.steps.size(), render, legends_of(render, view.aovs)});
        divide(step, render, view, table);
        job_.steps.push_back(std::move(step));
    }

    /// Views of one camera overlay: if a picture of the job has a legend, the same room is left in
    /// all, but in those with legend = false; that of the run itself where all need the same.
    void leave_room() {
        std::set<Legends> needs;
        for (const View& view : views_)
            if (view.render.legend) needs.insert(view.legends);
        if (needs.size() < 2) return;
        for (const View& view : views_)
            if (view.legends != Legends::maps && view.render.legend && !view.render.legend_room &&
                frames_by_name(view.render))
                job_.steps[view.step].arguments.push_back("--legend-room");
    }

    void divide(JobStep& step, const RenderConfig& render, const ViewTable& view,
                const TomlTable& table) {
        at_their_keys(table, [&] {
            const ViewDivision division = division_of_view(render, view.aovs, view.shares);
            step.shares =
                shares_of_view(render, view.aovs, step.output, view.name, division.shares);
            step.division = division.reason;
        });
    }

    static std::set<std::string> keys_of(const TomlTable& table) {
        std::set<std::string> keys;
        for (const TomlValue& value : table.values) keys.insert(value.key);
        return keys;
    }

    /// Options of all views that this one takes (or says itself).
    void note_taken(const std::vector<std::string>& options, const std::set<std::string>& own) {
        taken_.insert(own.begin(), own.end());
        for (const OptionUse& use : option_uses())
            for (const std::string& option : options)
                if (is_option(option, use.key)) taken_.insert(use.key);
    }

    /// Whether the command line says it, over the file.
    bool is_override(const std::string& key) const {
        const TomlTable* table = find_table(root_, "render", file_);
        return table && std::any_of(table->values.begin(), table->values.end(),
                                    [&](const TomlValue& value) {
                                        return value.key == key && value.line == kOnCommandLine;
                                    });
    }

    /// An option for all views, not as by default, that none takes.
    void refuse_idle() {
        RenderConfig usual;
        const FieldList given = fields_of(render_), defaults = fields_of(usual);
        for (const OptionUse& use : option_uses())
            if (given.find(use.key)->items() != defaults.find(use.key)->items() &&
                !taken_.contains(use.key) && (!overridden_ || is_override(use.key)))
                throw unused_option(use, place_of_default(use.key),
                                    is_override(use.key)
                                        ? fmt::format("no view of {} takes it", file_.string())
                                        : "no view takes it");
    }

    template <class PlaceOf>
    static void check_line_names(const std::vector<std::string>& options, const PlaceOf& place_of) {
        if (const auto wrong = wrong_line_file(options))
            throw ConfigError({.key = wrong->key, .problem = wrong->reason})
                .at(place_of(wrong->key));
    }

    Fault place_of_value(const TomlTable& table, const std::string& key) const {
        for (const TomlValue& value : table.values)
            if (value.key == key) return toml_fault(file_, value.line);
        return toml_fault(file_, table.line);
    }

    /// Where a view's key is said: in its table, or for all views; else where its table begins.
    Fault place_in_view(const TomlTable& view, const std::string& option) const {
        const std::string key = option == "aov" ? "aovs" : option;
        for (const TomlTable* table : {&view, find_table(root_, "render", file_),
                                       find_table(root_, "output", file_)}) {
            if (!table || (table->name == "output" && key != "aovs")) continue;
            for (const TomlValue& value : table->values)
                if (value.key == key) return toml_fault(file_, value.line);
        }
        return toml_fault(file_, view.line);
    }

    /// What a check of a view refuses, said of the line of the key that it names.
    template <class Check>
    void at_their_keys(const TomlTable& view, const Check& check) const {
        try {
            check();
        } catch (const ConfigError& error) {
            const bool is_shares = error.fault().key == "share";
            Fault said = error.fault();
            if (is_shares) said.key = "shares";
            throw ConfigError(said).at(place_in_view(view, said.key));
        }
    }

    /// Where [render], or the first [[light]], says it.
    Fault place_of_default(const std::string& key) const {
        for (const TomlTable& table : root_.tables) {
            if (table.name == "light" && key == "light") return toml_fault(file_, table.line);
            if (table.name != "render") continue;
            for (const TomlValue& value : table.values)
                if (value.key == key) return toml_fault(file_, value.line);
        }
        return {.file = file_.string()};
    }

    /// Checks what slim-render would refuse after the whole build.
    void check_all(RenderConfig render, const ViewTable& view, const TomlTable& table) const {
        render.aov = view.aovs;
        try {
            check_options(render);
        } catch (const ConfigError& error) {
            throw said_of_view(error, view.name, table);
        }
    }

    /// Where the view says that key, else where all views' tables do: then it is to be told which
    /// view cannot take it.
    ConfigError said_of_view(const ConfigError& error, const std::string& view,
                             const TomlTable& table) const {
        Fault fault = error.fault();
        const std::string key = fault.key == "aov" ? "aovs" : fault.key;
        const Fault own = place_of_value(table, key), of_all = place_of_default(key);
        const bool is_own = own.line != table.line || !own.said_by.empty();
        const bool is_of_all = !is_own && (of_all.line > 0 || !of_all.said_by.empty());
        if (is_of_all && n_views() > 1)
            fault.hint += fmt::format("{}view {}", fault.hint.empty() ? "" : "; ", view);
        return ConfigError(fault).at(is_of_all ? of_all : own);
    }

    /// Whether it asks for what models of [fit] have not, and notes that.
    bool is_beyond_fit(const std::vector<std::string>& aovs, const RenderConfig& render,
                       const TomlTable& table) {
        try {
            at_their_keys(table, [&] { check_view_of_fit(aovs, render, job_.stages); });
            return false;
        } catch (const ConfigError& error) {
            const auto is_said = [&](const ConfigError& said) {
                return std::string_view(said.what()) == error.what();
            };
            if (std::none_of(job_.refused.begin(), job_.refused.end(), is_said))
                job_.refused.push_back(error);
            return true;
        }
    }

    void check_view(const TomlTable& table, RenderConfig& config) const {
        const FieldList fields = fields_of(config);
        for (const TomlValue& value : table.values)
            if (const Field* field = fields.find(value.key))
                field->set(items_for(*field, value, file_.parent_path()),
                           toml_fault(file_, value.line, value.key));
        try {
            check_values(config);
        } catch (const ConfigError& error) {
            throw error.at(place_of_value(table, error.fault().key));
        }
    }

    void check_aovs(const std::vector<std::string>& aovs, const TomlTable& table) const {
        RenderConfig render;
        Fault place = place_in_view(table, "aovs");
        place.key = "aovs";
        fields_of(render).find("aov")->set(aovs, place);
    }

    /// Names come from views' tables, or from an option for all of them.
    [[noreturn]] void refuse_second(const std::string& name, const TomlTable& table) const {
        const std::string said = fmt::format("a second view of the name '{}'", name);
        const auto of_view = [&](const char* key) {
            return std::find_if(table.values.begin(), table.values.end(),
                                [&](const TomlValue& value) { return value.key == key; });
        };
        const auto named = of_view("name");
        const bool by_name = named != table.values.end();
        const bool by_option = by_name ? named->line == kOnCommandLine : is_override("camera");
        if (!by_option) throw ConfigError(said).at(toml_fault(file_, table.line));
        Fault fault = toml_fault(file_, kOnCommandLine, by_name ? "name" : "camera");
        fault.problem = fmt::format("{}, that of line {}", said, table.line);
        fault.expected = "views with names of their own";
        throw ConfigError(fault);
    }

    /// A view without a name takes its camera's, "view" if that is given by numbers. Options of its
    /// own win over those of all views.
    static std::string name_of(const std::vector<std::string>& of_all,
                               const std::vector<std::string>& own) {
        std::string camera = RenderConfig{}.camera;
        for (const auto* options : {&of_all, &own})
            for (const std::string& option : *options)
                if (option.starts_with("--camera=")) camera = option.substr(9);
        return camera.find(',') == std::string::npos ? camera : "view";
    }

    std::size_t n_views() const {
        return static_cast<std::size_t>(
            std::count_if(root_.tables.begin(), root_.tables.end(),
                          [](const TomlTable& table) { return table.name == "view"; }));
    }

    /// A file of lines is one view's, whatever else writes one or reads it.
    void check_line_file(const fs::path& file, const std::string& view, const TomlTable& table) {
        const fs::path path = fs::absolute(file).lexically_normal();
        const auto is_it = [&](const fs::path& other) {
            return !other.empty() && fs::absolute(other).lexically_normal() == path;
        };
        std::string other;
        if (const auto known = line_files_.find(path); known != line_files_.end())
            other = "view " + known->second + " writes too";
        for (const JobStep& step : job_.steps) {
            if (std::any_of(step.inputs.begin(), step.inputs.end(), is_it))
                other = step.name + " reads";
            if (is_it(step.output)) other = step.name + " writes";
        }
        if (!other.empty())
            throw ConfigError(
                {.problem = fmt::format("view {} would write its lines to {}, which {}", view,
                                        file.string(), other),
                 .expected = "a file of its own"})
                .at(toml_fault(file_, table.line));
        line_files_[path] = view;
    }

    const fs::path& file_;
    const TomlTable& root_;
    const std::vector<std::string>& usual_aovs_;
    const fs::path& model_;
    const fs::path& picture_;
    bool overridden_;
    Job& job_;
    std::set<std::string> taken_;  // keys for all views that some view takes
    AllViewsTable all_views_;
    struct View {
        std::size_t step;  // of the job's
        RenderConfig render;
        Legends legends;
    };
    std::vector<View> views_;
    RenderConfig render_;  // with what [render] and the lights say
    std::set<std::string> names_;
    std::vector<AskedView> asked_;
    std::map<fs::path, std::string> line_files_;  // and the view that writes them
};

}  // namespace

void read_job_views(const JobPictures& pictures, Job& job) {
    ViewReader reader(pictures, job);
    reader.read_views();
    reader.note_left_out();
}

}  // namespace slim
