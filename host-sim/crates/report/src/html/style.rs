//! The look of the page: on a screen, on a phone, in dark mode and on paper.

pub(crate) const STYLE: &str = "
:root { color-scheme: light dark; --line: #8884; --soft: #8881; --ink: #212529; --paper: #fff; --faint: #5f6770; --accent: #0060b0;
  --grid: #e4e7eb; --shade: rgba(255, 193, 7, .28); --trace-input: #6e6254; --trace-channel: #0060b0; --trace-recorded: #adb5bd; --trace-simulated: #0060b0; --trace-before: #d66000; --trace-after: #0060b0;
  --trace-model-0: #0060b0; --trace-model-1: #d66000; --trace-model-2: #00855c; --trace-model-3: #b23c8c; --trace-model-4: #8a6a00; --trace-model-5: #5a46be; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8ea; --paper: #181818; --faint: #a2a9b0; --accent: #6db3f2;
  --grid: #2c3036; --shade: rgba(255, 193, 7, .2); --trace-input: #b5a892; --trace-channel: #6db3f2; --trace-recorded: #6b737c; --trace-simulated: #6db3f2; --trace-before: #ff9a4d; --trace-after: #6db3f2;
  --trace-model-0: #6db3f2; --trace-model-1: #ff9a4d; --trace-model-2: #4cc79a; --trace-model-3: #e08cc4; --trace-model-4: #d6b44a; --trace-model-5: #a99bf0; }
  figure svg { filter: invert(.906) hue-rotate(180deg); } }
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper); max-width: 62rem; margin: 0 auto; padding: 1rem 1rem 4rem; }
header { margin-bottom: 1rem; }
h1 { font-size: 1.45rem; line-height: 1.3; margin: 0; padding-left: .7rem; border-left: 6px solid #8888; text-wrap: pretty; }
h1.remarks { border-color: #e0a800; } h1.missing { border-color: #d66000; } h1.nothing { border-color: #2b8a3e; } h1.unexplained { border-color: #b02a37; }
.about { border: 0; margin: 0 0 .6rem; font-size: .8rem; color: var(--faint); } .about summary { padding: 0; } .about dl { display: grid; grid-template-columns: max-content 1fr; gap: 0 .8rem; margin: .2rem 0 0; } .about dd { margin: 0; overflow-wrap: anywhere; } .about code { font-size: .75rem; }
.finding { margin: .9rem 0 0; padding-left: .7rem; border-left: 6px solid #d6600055; } .finding p { margin: .1rem 0; }
.contents ul { display: flex; flex-wrap: wrap; gap: .1rem 1.2rem; list-style: none; padding: .4rem 0; margin: 1rem 0 0; border-top: 1px solid var(--line); border-bottom: 1px solid var(--line); font-size: .875rem; } .contents a { color: var(--accent); text-decoration: none; }
h2 { font-size: 1.15rem; margin: 2.4rem 0 .4rem; padding-bottom: .2rem; border-bottom: 1px solid var(--line); } h3 { font-size: 1rem; margin: 1.4rem 0 .2rem; }
p { margin: .4rem 0; } .over { color: var(--faint); margin: 0 0 .2rem; } .soft { color: var(--faint); font-size: .875rem; }
.gains { list-style: none; display: flex; flex-wrap: wrap; gap: .5rem 2rem; padding: 0; margin: .8rem 0 0; }
.gains li { display: flex; flex-direction: column; } .name { color: var(--faint); font-size: .875rem; }
.number { font-size: 1.15rem; font-variant-numeric: tabular-nums; } .number strong { color: var(--accent); }
table { border-collapse: collapse; margin: .6rem 0; display: block; overflow-x: auto; }
th, td { padding: .2rem 1.2rem .2rem 0; border-bottom: 1px solid var(--line); text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
th { font-weight: 600; font-size: .875rem; } th:first-child, td:first-child, td.text, th.text { text-align: left; } tr.part td { padding-top: .6rem; font-weight: 600; } tr.part .soft { font-weight: 400; } td.text { white-space: normal; min-width: 12rem; }
figure { margin: .8rem 0; overflow-x: auto; } figure svg { width: 100%; height: auto; display: block; }
.whole { white-space: nowrap; } .multiples { display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: .2rem .8rem; } .multiples figure { margin: 0; } .overlay svg { min-width: 600px; } .chart svg { max-width: 640px; } .bars svg { max-width: 800px; min-width: 520px; }
.live:not(.drawn) > svg { display: none; } .recording { margin: .8rem 0 0; } figure .panel { font-weight: 600; font-size: .875rem; margin: .5rem 0 .1rem; }
figure .remark { font-size: .8rem; margin: .1rem 0 .2rem; padding-left: .5rem; border-left: 4px solid #e0a800; } figure .quantity { color: var(--faint); font-size: .8rem; margin: 0; } .uplot { max-width: 100%; } .uplot .u-legend { font-size: .8rem; text-align: left; margin: 0; color: var(--ink); }
.u-legend.u-inline.u-live th::after { content: none; } .u-legend tr { margin-right: .9rem; } .uplot:not(:hover) .u-legend tr:first-child { visibility: hidden; } .u-legend th, .u-legend td { border: 0; padding: .1rem .2rem; } .u-legend td { min-width: 4.5rem; text-align: left; }
.u-legend .branch { display: none; } .u-legend, .u-legend tbody { display: block; overflow: visible; } .u-select { background: color-mix(in srgb, var(--accent) 18%, transparent); }
.switches { font-size: .8rem; margin: .2rem 0; min-height: 1.6rem; } .switches button { font: inherit; color: inherit; background: none; border: 0; cursor: pointer; padding: .1rem .8rem .1rem .2rem; font-weight: 600; }
.switches button::before { content: ''; display: inline-block; width: 1em; height: 1em; margin-right: .3em; vertical-align: -.1em; background: var(--mark); } .switches button[aria-pressed=false] { opacity: .35; }
figure svg rect { shape-rendering: crispEdges; } .live.data { overflow-x: visible; } .live.drawn.data { overflow-x: auto; } ol { padding-left: 1.4rem; } li { margin: .2rem 0; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 26rem), 1fr)); gap: 0 1rem; }
.wide { font-size: .875rem; } .wide th, .wide td { padding-right: .9rem; } .wide td.text { min-width: 11rem; line-height: 1.3; }
@media (max-width: 30rem) { .gains { display: grid; grid-template-columns: 1fr 1fr; gap: .5rem .8rem; } .number { font-size: 1rem; } h1 { font-size: 1.25rem; } }
.fact { padding: .3rem .9rem; background: var(--soft); border-radius: 4px; margin: .6rem 0; }
ul.fact { padding-left: 1.6rem; } .fact.remark { border-left: 4px solid #e0a800; } .links th { padding-right: 1.4rem; white-space: nowrap; } .links tr.alone th { color: #2b8a3e; } .links tr.together th { color: #b26a00; } .links tr.not th { color: #b02a37; }
@media (prefers-color-scheme: dark) { .links tr.alone th { color: #69db7c; } .links tr.together th { color: #ffc078; } .links tr.not th { color: #ff8787; } }
code, pre { font: .875rem/1.45 ui-monospace, monospace; } pre { padding: .7rem .9rem; background: var(--soft); border-radius: 4px; overflow-x: auto; }
summary { cursor: pointer; padding: .35rem 0; } details { border-bottom: 1px solid var(--line); }
@media print { body { max-width: none; padding: 0; font-size: 13px; } figure, tr, .fact, pre { break-inside: avoid; } h1, h2, h3, summary, .recording { break-after: avoid; } h2 { margin-top: 1.4rem; }
  .contents { display: none; } table { display: table; font-size: .8rem; } td.text, .wide td.text { min-width: 0; } th, td { white-space: normal; padding-right: .7rem; } .pair { grid-template-columns: 1fr 1fr; } .overlay svg { max-height: 20cm; }
  details::details-content { content-visibility: visible; block-size: auto; }
  :root { --ink: #000; --paper: #fff; --faint: #444; --accent: #0060b0; color-scheme: light; } .live > svg { display: block !important; } .plots, .told { display: none; }
  figure svg { filter: none !important; } .overlay svg, .chart svg, .bars svg { min-width: 0; } }
";
