//! How the page looks: on a screen, on a phone, in the dark and on paper.

pub(super) const STYLE: &str = "
:root { color-scheme: light dark; --line: #8884; --soft: #8881; --ink: #212529; --paper: #fff; --faint: #5f6770; --accent: #0060b0; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8ea; --paper: #16181b; --faint: #a2a9b0; --accent: #6db3f2; }
  figure svg { filter: invert(.9) hue-rotate(180deg); } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 62rem; margin: 0 auto; padding: 1rem 1rem 4rem; }
header { margin-bottom: 1rem; }
h1 { font-size: 1.45rem; line-height: 1.3; margin: 0; padding-left: .7rem; border-left: 6px solid #8888; text-wrap: balance; }
h1.missing { border-color: #d66000; } h1.nothing { border-color: #2b8a3e; } h1.unexplained { border-color: #b02a37; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .4rem; padding-bottom: .2rem; border-bottom: 1px solid var(--line); } h3 { font-size: 1rem; margin: 1.4rem 0 .2rem; }
p { margin: .4rem 0; } .over { color: var(--faint); margin: 0 0 .2rem; } .soft { color: var(--faint); font-size: .875rem; }
.gains { list-style: none; display: flex; flex-wrap: wrap; gap: .5rem 2rem; padding: 0; margin: .8rem 0 0; }
.gains li { display: flex; flex-direction: column; } .name { color: var(--faint); font-size: .875rem; }
.number { font-size: 1.15rem; font-variant-numeric: tabular-nums; } .number strong { color: var(--accent); }
table { border-collapse: collapse; margin: .6rem 0; display: block; overflow-x: auto; }
th, td { padding: .2rem 1.2rem .2rem 0; border-bottom: 1px solid var(--line); text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
th { font-weight: 600; font-size: .875rem; } th:first-child, td:first-child, td.text, th.text { text-align: left; } td.text { white-space: normal; min-width: 12rem; }
figure { margin: .8rem 0; overflow-x: auto; } figure svg { width: 100%; height: auto; display: block; }
.overlay svg { min-width: 600px; } .chart svg { max-width: 640px; } .bars svg { max-width: 800px; min-width: 520px; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); gap: 0 1rem; }
.fact { padding: .3rem .9rem; background: var(--soft); border-radius: 4px; margin: .6rem 0; }
code, pre { font: .875rem/1.45 ui-monospace, monospace; } pre { padding: .7rem .9rem; background: var(--soft); border-radius: 4px; overflow-x: auto; }
summary { cursor: pointer; padding: .35rem 0; } details { border-bottom: 1px solid var(--line); }
@media print { body { max-width: none; } section, figure, table { break-inside: avoid; } details::details-content { content-visibility: visible; block-size: auto; }
  figure svg { filter: none; } .overlay svg, .chart svg, .bars svg { min-width: 0; } }
";
