#pragma once

namespace tintree::audit {

/// The style sheet of the report's page.
inline constexpr const char* kReportStyle = R"css(
:root { --ink: #1d2329; --soft: #57606a; --line: #d5d9de; --paper: #ffffff; --band: #f4f5f3; --data: #3b6e8f;
  --pass: #1b6e53; --fail: #a3123a; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--paper); color: var(--ink);
  font: 15px/1.5 "Source Sans 3", "Segoe UI", "Helvetica Neue", Arial, "DejaVu Sans", sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 28px 28px 64px; }
h1 { font-size: 15px; font-weight: 600; color: var(--soft); margin: 0 0 10px; overflow-wrap: anywhere; }
h2 { font-size: 21px; margin: 44px 0 4px; letter-spacing: -0.01em; }
h3 { font-size: 15px; margin: 0 0 6px; }
p { margin: 4px 0 12px; max-width: 76ch; }
.soft, figcaption, .note { color: var(--soft); }
.verdict { border-left: 8px solid var(--pass); background: #eef5f1; padding: 18px 24px; }
.verdict.fail { border-color: var(--fail); background: #faeef1; }
.verdict strong { display: block; font-size: 34px; line-height: 1.15; letter-spacing: -0.02em; color: var(--pass); }
.verdict.fail strong { color: var(--fail); }
.verdict p { font-size: 17px; margin: 6px 0 0; }
.facts { display: grid; grid-template-columns: repeat(auto-fit, minmax(165px, 1fr)); gap: 0 28px; margin: 22px 0 0; }
.facts div { border-top: 1px solid var(--line); padding: 8px 0 10px; }
.facts b { display: block; font-size: 22px; font-weight: 600; letter-spacing: -0.01em; }
.facts span { color: var(--soft); font-size: 13px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; margin: 10px 0 6px; }
th, td { text-align: right; padding: 5px 0 5px 14px; white-space: nowrap; vertical-align: top; }
th { font-weight: 600; font-size: 13px; color: var(--soft); border-bottom: 2px solid var(--ink); vertical-align: bottom; }
td { border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { padding-left: 0; }
.text { text-align: left; white-space: normal; }
table.checks td.text:first-child { white-space: nowrap; padding-right: 6px; font-weight: 600; }
td.ok { color: var(--pass); font-weight: 600; }
td.bad { color: var(--fail); font-weight: 600; }
td.off { color: var(--soft); }
.scroll { overflow-x: auto; }
.grid { display: grid; grid-template-columns: repeat(auto-fill, minmax(320px, 1fr)); gap: 22px 26px; margin-top: 14px; }
figure { margin: 0; }
figure img { display: block; width: 100%; height: auto; image-rendering: auto; border: 1px solid var(--line); }
figcaption { font-size: 13px; padding-top: 5px; }
.views { grid-template-columns: repeat(2, minmax(0, 1fr)); }
.legend { display: flex; align-items: center; gap: 10px; font-size: 13px; color: var(--soft); flex-wrap: wrap; }
.legend .scale { width: 220px; height: 14px; border: 1px solid var(--line); }
.legend .swatch { width: 14px; height: 14px; border: 1px solid var(--line); margin-left: 10px; }
svg text { font-size: 11px; fill: var(--soft); }
.histogram { width: 100%; height: auto; }
.histogram rect { fill: var(--data); }
.histogram .axis, .histogram .tick { stroke: var(--ink); stroke-width: 1; }
.histogram .mark { stroke: #c2571a; stroke-width: 1.5; }
.histogram text.mark { stroke: none; fill: #a8470f; }
.bar { width: 150px; height: 10px; vertical-align: middle; background: var(--band); }
.bar rect { fill: var(--data); }
.tile { border-top: 1px solid var(--line); padding: 14px 0 6px; }
.triple { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 16px; max-width: 900px; }
.shot { position: relative; display: block; }
.shot svg { position: absolute; inset: 0; width: 100%; height: 100%; }
.shot circle { fill: none; stroke: #fff; stroke-width: 5; vector-effect: non-scaling-stroke; }
.shot circle + circle { stroke: #000; stroke-width: 2; }
code { font-family: "DejaVu Sans Mono", Consolas, monospace; font-size: 13px; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 3px 18px; margin: 10px 0; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
)css";

}  // namespace tintree::audit
