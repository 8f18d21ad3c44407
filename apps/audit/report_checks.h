#pragma once

#include <string>

#include "apps/audit/report_page.h"

namespace tintree::audit {

/// The table of what was checked, in plain words, with the number of violations of each kind.
std::string checks_table(const ReportInput& input);

/// The violations themselves, the worst first; empty when there is none.
std::string violations_table(const TreeReport& report);

}  // namespace tintree::audit
