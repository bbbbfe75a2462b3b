// Draws the formulas with KaTeX, when the page is there.
document.addEventListener("DOMContentLoaded", () => {
    for (const node of document.querySelectorAll(".math")) {
        katex.render(node.textContent, node, {
            displayMode: node.tagName === "DIV", throwOnError: false, strict: false, output: "htmlAndMathml",
        });
    }
});
