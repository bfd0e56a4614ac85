// The sections of a run as its report has them, asked for when the run is there and drawn in place; one set is seen at a time.
const FIRST = ["opening", "answers", "force"];
const ORDER = ["sweep", "motion", "train", "in-motion", "coils", "orders", "at-rest", "stress", "critical-speeds", "energy", "events", "kinematics", "published"];
// Short words for the tabs; a section of another package keeps its title.
const SHORT = { sweep: "Over engine speed", motion: "Lift and motion", train: "Train", coils: "Coils and clashes", "in-motion": "Spring in motion", orders: "Orders", "at-rest": "Static curve and modes",
  stress: "Stress", energy: "Energy", published: "Published values", "source-readings": "Source", uncertainty: "Error bars",
  case: "Case", runs: "Computation", references: "Papers" };
export default {
  emits: ["shown"],
  props: { source: String, whole: Boolean, name: String },
  data() { return { tabs: [], chosen: "", sentence: "", shown: "" }; },
  mounted() { this.load(); },
  beforeUnmount() { this.leave(); },
  watch: { source() { this.load(); } },
  methods: {
    async load() {
      const source = this.source;
      if (!source) { this.leave(); this.$refs.place.replaceChildren(); this.tabs = []; this.shown = ""; return; }
      const began = performance.now();
      const answer = await fetch(source);
      const text = await answer.text();
      this.fetched = performance.now() - began;
      if (source !== this.source) { return; }
      if (!answer.ok) { this.sentence = text; return; }
      this.sentence = "";
      this.fill(text, source, began);
    },
    async fill(text, source, began) {
      const place = this.$refs.place;
      this.leave();
      place.innerHTML = text;
      place.querySelectorAll(".scroll").forEach((part) => {
        part.tabIndex = 0;
        part.setAttribute("role", "group");
        part.setAttribute("aria-label", "table: " + (part.querySelector("caption")?.textContent || "values"));
      });
      place.querySelectorAll(".card th:empty, thead th:empty").forEach((cell) => { cell.innerHTML = '<span class="off-screen">quantity</span>'; });
      // A tab is fold enough.
      place.querySelectorAll("details.computed").forEach((fold) => { fold.replaceWith(...fold.querySelectorAll(":scope > section")); });
      place.querySelectorAll("details.part").forEach((fold) => {
        const summary = fold.querySelector(":scope > summary");
        summary.replaceWith(...summary.childNodes);
        fold.replaceWith(...fold.childNodes);
      });
      const sections = Array.from(place.querySelectorAll("section"));
      if (this.whole || sections.length < 3) {
        this.tabs = [];
      } else {
        const rank = (section) => (ORDER.includes(section.id) ? ORDER.indexOf(section.id) : ORDER.length);
        const first = sections.filter((section) => FIRST.includes(section.id));
        const others = sections.filter((section) => !FIRST.includes(section.id)).sort((one, other) => rank(one) - rank(other));
        this.tabs = [{ key: "overview", title: "Overview", sections: first.length ? first : others.splice(0, 2) },
          ...others.map((section) => ({ key: section.id, title: SHORT[section.id] || (section.querySelector("h2")?.textContent || section.id), sections: [section] }))];
        this.choose(this.tabs.some((tab) => tab.key === this.chosen) ? this.chosen : "overview");
      }
      valvetrainFigures.wire(place);
      await window.valvetrainDrawing;
      if (source !== this.source) { return; }
      valvetrainFigures.watch(place);
      this.drawNear();
      this.shown = source;
      window.valvetrainResults = { source, fetched: this.fetched / 1000, seconds: (performance.now() - began) / 1000, at: Date.now() / 1000 };
      this.$emit("shown", window.valvetrainResults);
      if (source.startsWith("/part/")) { setTimeout(() => this.loadRest(source), 0); }
    },
    // Data of the figures that are not seen first.
    async loadRest(source) {
      const answer = await fetch(source.replace("/part/", "/rest/"));
      const text = await answer.text();
      if (source !== this.source || !answer.ok) { return; }
      const data = document.createElement("div");
      data.hidden = true;
      data.innerHTML = text;
      this.$refs.place.append(data);
      valvetrainFigures.watch(this.$refs.place);
    },
    // Moving pictures hold a drawing context each, of which a browser has few.
    leave() { this.$refs.place.querySelectorAll("[data-motion]").forEach((box) => { if (box.motion) { box.motion.destroy(); } }); },
    choose(key) {
      this.chosen = key;
      this.tabs.forEach((tab) => tab.sections.forEach((section) => { section.hidden = tab.key !== key; }));
      this.drawNear();
    },
    // The first figure, and what stands in or near the window, are drawn at once, the rest as it comes near.
    drawNear() {
      this.$refs.place.querySelectorAll("section:not([hidden]) .plot[data-chart]").forEach((box, place) => {
        const frame = box.getBoundingClientRect();
        if (frame.width && (place === 0 || frame.top < window.innerHeight + 100)) { valvetrainFigures.draw(box); }
      });
    },
    step(event, by) {
      const place = (this.tabs.findIndex((tab) => tab.key === this.chosen) + by + this.tabs.length) % this.tabs.length;
      this.choose(this.tabs[place].key);
      this.$nextTick(() => event.target.closest("[role=tablist]").querySelectorAll("button")[place].focus());
    },
  },
  template: `
<div class="results" :data-shown="shown || null">
  <p v-if="sentence" class="refusal" role="alert">{{ sentence }}</p>
  <div v-if="tabs.length" class="jump scroll" role="tablist" :aria-label="name || 'results'" @keydown.right.prevent="step($event, 1)" @keydown.left.prevent="step($event, -1)">
    <button v-for="tab in tabs" :key="tab.key" type="button" role="tab" :id="'tab-' + tab.key" :aria-selected="tab.key === chosen ? 'true' : 'false'"
      :tabindex="tab.key === chosen ? 0 : -1" aria-controls="result-sections" @click="choose(tab.key)">{{ tab.title }}</button>
  </div>
  <div ref="place" :id="whole ? null : 'result-sections'" :role="tabs.length ? 'tabpanel' : null" :aria-labelledby="tabs.length ? 'tab-' + chosen : null"></div>
</div>`,
};
