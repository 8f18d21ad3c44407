#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "apps/build/build_tree.h"
#include "apps/build/plan.h"

namespace tintree::app {

/// The table of levels and the totals that a build ends with.
std::string summary_text(const BuildReport& report, const std::string& output);

/// The same for programs; keys as of docs/guide.md.
nlohmann::ordered_json summary_json(const BuildReport& report);

/// The plan as a table for people, and for --json under the report's keys.
std::string plan_text(const TreePlan& plan);
nlohmann::ordered_json plan_json(const TreePlan& plan, const BuildOptions& options);

}  // namespace tintree::app
