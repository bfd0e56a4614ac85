// An answer of this server; its figures are drawn as its folds open. Folds that were open are open in the next answer too.
export default {
  props: { source: String },
  data() { return { sentence: "", shown: "" }; },
  mounted() { this.load(); },
  beforeUnmount() { this.leave(); },
  watch: { source() { this.load(); } },
  methods: {
    async load() {
      const source = this.source, began = performance.now();
      const answer = source ? await fetch(source) : null;
      const content = answer?.ok ? await answer.json() : { html: "", sentence: answer ? await answer.text() : "" };
      const fetched = performance.now() - began;
      if (source !== this.source) { return; }
      const place = this.$refs.place, open = Array.from(place.querySelectorAll("section:has(> details[open])"), (part) => part.id);
      this.leave();
      this.sentence = content.sentence || "";
      place.innerHTML = content.html;
      open.forEach((id) => { const fold = place.querySelector("#" + CSS.escape(id) + " > details"); if (fold) { fold.open = true; } });
      if (!content.html) { this.shown = ""; return; }
      await window.valvetrainDrawing;
      if (source !== this.source) { return; }
      await valvetrainFigures.begin(place, content.data);
      this.shown = source;
      window.valvetrainResults = { source, fetched: fetched / 1000, seconds: (performance.now() - began) / 1000, at: Date.now() / 1000 };
    },
    // Moving pictures hold a drawing context each, of which a browser has few.
    leave() { this.$refs.place.querySelectorAll("[data-motion]").forEach((box) => { if (box.motion) { box.motion.destroy(); } }); },
  },
  template: `
<div class="results" :data-shown="shown || null">
  <p v-if="sentence" class="refusal" role="alert">{{ sentence }}</p>
  <div ref="place"></div>
</div>`,
};
